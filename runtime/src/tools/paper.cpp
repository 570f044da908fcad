// The paper's blending of several tools, equations (15)-(16).
#include <phynness/phynness_tools.h>

#include <cmath>

#include "core/evaluate.hpp"

using namespace PHN_RUNTIME;

namespace {

/// Checks the tools of a deformation and copies them into the data. @return a status of phynness.h
int read_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const std::int32_t* nodes,
               const double* displacements) {
  if (nodes == nullptr || displacements == nullptr) return PHN_ERROR_ARGUMENT;
  if (n_tools > data.max_tools) return PHN_ERROR_TOOLS;
  int status = PHN_OK;
  for (std::int32_t t = 0; t < n_tools; ++t) {
    double* d = data.asked + 3 * static_cast<std::size_t>(t);
    data.asked_nodes[t] = nodes[t];
    for (int k = 0; k < 3; ++k) d[k] = displacements[3 * static_cast<std::size_t>(t) + k];
    const std::int32_t at = find_active(model, data.asked_nodes[t]);
    if (at < 0) return PHN_ERROR_NOT_ACTIVE;
    if (!finite(d)) return PHN_ERROR_NOT_FINITE;
    if (n_tools > 1 && model.active[at].moves_mean) return PHN_ERROR_ROUND_TOOLS;
    if (!has_deformation(model, model.active[at])) return PHN_ERROR_UNDEFINED;
    status |= warnings(model, model.active[at], d);
  }
  return status;
}

double distance_between(const double* a, const double* b) {
  const double t[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return length(t);
}

void blend_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const std::int32_t* nodes,
                 const double* displacements, double* out) {
  const auto tool = [&](std::int32_t t) -> const ActiveNode& { return model.active[find_active(model, nodes[t])]; };
  for (std::int32_t o = 0; o < model.n_output; ++o) {
    const double* point = &model.output_points[3 * o];
    double nearest = distance_between(point, tool(0).point);
    for (std::int32_t t = 1; t < n_tools; ++t) nearest = std::fmin(nearest, distance_between(point, tool(t).point));
    // Equation (16) with numerator and denominator multiplied by the smallest distance, so that every term is in [0,
    // 1].
    double sum = 0;
    for (std::int32_t t = 0; t < n_tools; ++t) {
      const double distance = distance_between(point, tool(t).point);
      sum += distance > 0 ? nearest / distance : 1;
    }
    data.nearest[o] = nearest;
    data.weight_sum[o] = sum;
    for (int k = 0; k < 3; ++k) out[3 * o + k] = 0;
  }
  for (std::int32_t t = 0; t < n_tools; ++t) {
    evaluate_deformation(model, data, find_active(model, nodes[t]), &displacements[3 * t], data.field);
    for (std::int32_t o = 0; o < model.n_output; ++o) {
      const double distance = distance_between(&model.output_points[3 * o], tool(t).point);
      const double weight = (distance > 0 ? data.nearest[o] / distance : 1) / data.weight_sum[o];
      for (int k = 0; k < 3; ++k) out[3 * o + k] += weight * data.field[3 * o + k];
    }
  }
  // At a touched node the weights are singular; their limit is the displacement of its tool, or of its tools the mean.
  for (std::int32_t t = 0; t < n_tools; ++t) {
    const std::int32_t o = tool(t).output;
    for (int k = 0; k < 3 && o >= 0; ++k) {
      double sum = 0, n = 0;
      for (std::int32_t s = 0; s < n_tools; ++s) {
        if (nodes[s] != nodes[t]) continue;
        sum += displacements[3 * s + k];
        ++n;
      }
      out[3 * o + k] = sum / n;
    }
  }
}

}  // namespace

int phn_blend_paper(const phn_model* model, phn_data* data, int32_t n_tools, const int32_t* nodes,
                    const double* displacements, double* out) {
  if (model == nullptr || out == nullptr) return PHN_ERROR_ARGUMENT;
  int status = PHN_OK;
  if (data == nullptr || data->model != model || n_tools < 0) {
    status = PHN_ERROR_ARGUMENT;
  } else if (n_tools > 0) {
    status = read_tools(*model, *data, n_tools, nodes, displacements);
  }
  if (status < 0 || n_tools == 0) return refuse(status, out, 3 * model->n_output);
  if (n_tools == 1) {
    evaluate_deformation(*data->level, *data, find_active(*model, data->asked_nodes[0]), data->asked, out);
  } else {
    blend_tools(*data->level, *data, n_tools, data->asked_nodes, data->asked, out);
  }
  return status;
}
