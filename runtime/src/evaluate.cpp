#include "evaluate.hpp"

#include <cmath>

#include "local_response.hpp"
#include "modal.hpp"
#include "network_kernels.hpp"

namespace phynness::runtime {
namespace {

double distance_between(const double* a, const double* b) {
  const double t[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return length(t);
}

}  // namespace

double length(const double* d) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::fmax(largest, std::fabs(d[k]));
  if (largest > 1e-140 && largest < 1e140) return std::sqrt(dot(d, d));
  if (!(largest > 0) || std::isinf(largest)) return largest;
  // Scaled by a power of two, which is exact, the squares stay in range.
  int exponent = 0;
  std::frexp(largest, &exponent);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double t = std::ldexp(d[k], -exponent);
    sum += t * t;
  }
  return std::ldexp(std::sqrt(sum), exponent);
}

void linear_field(const phn_model& model, const LinearResponse& linear, const double* d, double* field) {
  const double x = d[0], y = d[1], z = d[2];
  const double *ux = linear.unit_response[0], *uy = linear.unit_response[1], *uz = linear.unit_response[2];
  for (std::int32_t i = 0; i < 3 * model.n_output; ++i) field[i] = x * ux[i] + y * uy[i] + z * uz[i];
}

void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force) {
  switch (model.family) {
    case Family::rbfn:
      return best_network_kernels().force(node.networks->force, d, force);
    case Family::linear: {
      double at[3];
      cut(d, 1, largest_linear, at);
      return multiply_symmetric(node.linear->stiffness, at, force);
    }
    case Family::modal:
      return modal_force(*node.modal, d, force);
  }
}

double evaluate_energy(const phn_model& model, const ActiveNode& node, const double* d) {
  if (model.family == Family::modal) return modal_energy(*node.modal, d);
  double at[3], force[3];
  cut(d, 1, largest_linear, at);
  multiply_symmetric(node.linear->stiffness, at, force);
  return dot(at, force) / 2;
}

void evaluate_stiffness(const phn_model& model, const ActiveNode& node, const double* d, double* stiffness) {
  if (model.family == Family::modal) return modal_stiffness(*node.modal, d, stiffness);
  const double* k = node.linear->stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) stiffness[3 * i + j] = stiffness[3 * j + i] = *k++;
  }
}

bool has_energy(const phn_model& model) { return model.family != Family::rbfn; }

bool has_deformation(const phn_model& model, const ActiveNode& node) {
  return model.family != Family::modal || node.modal->n_modes > 0;
}

void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d,
                          double* field) {
  const ActiveNode& node = model.active[active];
  double* basis = data.scratch + model.n_scratch - model.n_basis;
  basis_of(model, node, d, basis, data.scratch);
  field_of_basis(model, node, prepare(model, data.prepared, active), 1, d, basis, data.scratch, field);
}

void blend_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const std::int32_t* nodes,
                 const double* displacements, double* out) {
  const auto tool = [&](std::int32_t t) -> const ActiveNode& {
    return model.active[find_active(model, nodes[t])];
  };
  for (std::int32_t o = 0; o < model.n_output; ++o) {
    const double* point = &model.output_points[3 * o];
    double nearest = distance_between(point, tool(0).point);
    for (std::int32_t t = 1; t < n_tools; ++t)
      nearest = std::fmin(nearest, distance_between(point, tool(t).point));
    // (16) with numerator and denominator multiplied by the smallest distance: every term lies in [0, 1].
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
  // At a touched node the weights are singular; their limit is the node's own displacement.
  for (std::int32_t t = 0; t < n_tools; ++t) {
    if (tool(t).output < 0) continue;
    for (int k = 0; k < 3; ++k) out[3 * tool(t).output + k] = displacements[3 * t + k];
  }
}

bool outside(const phn_model& model, const ActiveNode& node, const double* d) {
  if (model.family == Family::linear) return length(d) > largest_linear;
  // No root for most: squares that overflow or underflow go on below.
  if (dot(d, d) < node.least_depth * node.least_depth) return false;
  // The deepest increment itself is inside, however its direction was rounded.
  const double slack = 1 + 1e-9;
  const double size = length(d);
  return size > slack * node.least_depth && size > slack * trained_depth(model, node, d);
}

double trained_depth(const phn_model& model, const ActiveNode& node, const double* d) {
  const double size = length(d);
  double depth = 0, best = -2;
  for (std::int32_t i = 0; i < model.n_directions; ++i) {
    const double* e = &model.directions[3 * i];
    if (size > 0) {
      // d is divided first: its squares could leave the range of double.
      const double along = size < 1e-290 || size > 1e290
                               ? (d[0] / size) * e[0] + (d[1] / size) * e[1] + (d[2] / size) * e[2]
                               : (d[0] * e[0] + d[1] * e[1] + d[2] * e[2]) / size;
      if (along > best) {
        best = along;
        depth = node.trained_depth[i];
      }
    } else if (node.trained_depth[i] > 0 && (depth == 0 || node.trained_depth[i] < depth)) {
      depth = node.trained_depth[i];
    }
  }
  return depth;
}

}  // namespace phynness::runtime
