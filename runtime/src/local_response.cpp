#include "local_response.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "modal_kernels.hpp"
#include "network_kernels.hpp"

namespace phynness::runtime {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (list[i] == value) return i;
  }
  return -1;
}

void add_row(const std::int16_t* row, const double* scale, double factor, std::int32_t m, double* sum) {
  for (std::int32_t j = 0; j < m; ++j) sum[j] += factor * (row[j] * scale[j]);
}

/// One component of one output node's displacement, per amplitude.
void add_modes(const phn_model& model, const ModalResponse& node, std::int32_t output, int component,
               double weight, double* sum) {
  const auto m = static_cast<std::size_t>(node.n_columns);
  const std::int32_t at = find_sorted(node.near, node.n_near, output);
  if (at >= 0) {
    const std::size_t row = 3 * static_cast<std::size_t>(at) + static_cast<std::size_t>(component);
    return add_row(node.near_mode + row * m, node.near_mode_scale, weight, node.n_modes, sum);
  }
  const std::int32_t row = 3 * output + component, block = row / rows_per_block;
  const float* mode = model.shared.modes + static_cast<std::size_t>(block) * rows_per_block *
                                               static_cast<std::size_t>(model.shared.n_modes);
  for (std::int32_t s = 0; s < model.shared.n_modes; ++s) {
    const double factor = weight * static_cast<double>(mode[s * rows_per_block + row % rows_per_block]);
    add_row(node.mixing + static_cast<std::size_t>(s) * m, node.mixing_scale, factor, node.n_modes, sum);
  }
}

void add_gaussians(const phn_model& model, const Network& net, std::int32_t output, double weight,
                   LocalResponse& local) {
  const double* point = model.output_points + 3 * static_cast<std::size_t>(output);
  double x[3];
  for (int k = 0; k < 3; ++k) x[k] = (point[k] - net.input_center[3 + k]) / net.input_half_range[3 + k];
  for (std::int32_t i = 0; i < net.n_neurons; ++i) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
      const double y = x[k] - net.center[3 + k][i];
      square += y * y;
    }
    const double h = weight * std::exp(-square * net.inverse_square_spread);
    for (int k = 0; k < 3; ++k)
      local.rows[k * net.n_neurons + i] += h * net.output_half_range[k] * net.weight[k][i];
  }
  for (int k = 0; k < 3; ++k)
    local.constant[k] += weight * (net.output_center[k] + net.output_half_range[k] * net.bias[k]);
}

/// Of a stiffness at rest, over the cube of its mean diagonal. Forces between nodes are the same from 0 to 0.05.
constexpr double least_determinant = 0.01;

/// Raises a symmetric matrix by a multiple of 1 until it resists in every direction: beside a snap fits at rest do not,
/// and what a point between such nodes does is then the difference of large numbers.
void stiffen(double* k) {
  const double mean = (std::fabs(k[0]) + std::fabs(k[4]) + std::fabs(k[8])) / 3, shift = mean / 16;
  const double d[3] = {k[0], k[4], k[8]};
  for (int step = 0; step < 64; ++step) {
    const double second = k[0] * k[4] - k[1] * k[1];
    const double third = k[0] * (k[4] * k[8] - k[5] * k[5]) - k[1] * (k[1] * k[8] - k[5] * k[2]) +
                         k[2] * (k[1] * k[5] - k[4] * k[2]);
    if (k[0] > 0 && second > 0 && third > least_determinant * mean * mean * mean) return;
    for (int i = 0; i < 3; ++i) k[4 * i] = d[i] + (step + 1) * shift;
  }
}

}  // namespace

std::int32_t basis_size(const phn_model& model, const ActiveNode& node) {
  switch (model.family) {
    case Family::rbfn:
      return node.networks->deformation.n_neurons;
    case Family::modal:
      return node.modal->n_modes;
    case Family::linear:
      break;
  }
  return 3;
}

void basis_of(const phn_model& model, const ActiveNode& node, const double* d, double* basis, double* scratch) {
  switch (model.family) {
    case Family::rbfn:
      return best_network_kernels().of_displacement(node.networks->deformation, d, basis);
    case Family::linear:
      return cut(d, 1, largest_linear, basis);
    case Family::modal: {
      double x[3];
      cut(d, model.max_displacement, largest_modal, x);
      const ModalKernels& kernels = best_modal_kernels();
      kernels.basis(model.shared, x, scratch);
      return kernels.amplitudes(*node.modal, model.shared.n_centers + 3, scratch, basis);
    }
  }
}

void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch,
                            double* other) {
  const std::int32_t n = basis_size(model, node);
  const double h = model.family == Family::linear ? 1 : model.first_increment;
  for (int k = 0; k < 3; ++k) {
    const double to[3] = {k == 0 ? h : 0, k == 1 ? h : 0, k == 2 ? h : 0}, from[3] = {-to[0], -to[1], -to[2]};
    basis_of(model, node, to, gradient + k * n, scratch);
    basis_of(model, node, from, other, scratch);
    for (std::int32_t j = 0; j < n; ++j) gradient[k * n + j] = (gradient[k * n + j] - other[j]) / (2 * h);
  }
}

void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch) {
  const std::int32_t n = basis_size(model, node);
  switch (model.family) {
    case Family::rbfn: {
      const Network& net = node.networks->deformation;
      best_network_kernels().of_displacement(net, d, basis);
      for (std::int32_t i = 0; i < n; ++i) {
        for (int k = 0; k < 3; ++k) {
          const double y = (d[k] - net.input_center[k]) / net.input_half_range[k] - net.center[k][i];
          gradient[k * n + i] = -2 * y * net.inverse_square_spread / net.input_half_range[k] * basis[i];
        }
      }
      return;
    }
    case Family::linear:
      basis_of(model, node, d, basis, scratch);
      for (int i = 0; i < 9; ++i) gradient[i] = i % 4 == 0 ? 1 : 0;
      return;
    case Family::modal: {
      const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
      const ModalKernels& kernels = best_modal_kernels();
      kernels.basis(model.shared, x, scratch);
      kernels.amplitudes(*node.modal, model.shared.n_centers + 3, scratch, basis);
      return amplitude_gradient(model, node, d, gradient, scratch);
    }
  }
}

void amplitude_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* gradient,
                        double* scratch) {
  const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis_gradient(model.shared, x, scratch);
  kernels.three_amplitudes(*node.modal, model.shared.n_centers + 3, scratch, gradient);
  for (std::int32_t j = 0; j < 3 * node.modal->n_modes; ++j) gradient[j] /= R;
}

void prepare_local(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
                   const double* weights, LocalResponse& local) {
  const std::int32_t size = basis_size(model, node);
  local.direct = 0;
  for (int k = 0; k < 3; ++k) local.constant[k] = 0;
  for (std::int32_t i = 0; i < 3 * size; ++i) local.rows[i] = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t vertex = vertices[i];
    if (vertex < 0 || vertex >= model.n_output || weights[i] == 0) continue;
    const std::int32_t moved = position_of(node.prescribed, node.n_prescribed, vertex);
    if (moved >= 0) {
      local.direct += weights[i] * node.prescribed_weight[moved];
      continue;
    }
    switch (model.family) {
      case Family::rbfn:
        add_gaussians(model, node.networks->deformation, vertex, weights[i], local);
        break;
      case Family::linear:
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l)
            local.rows[3 * k + l] += weights[i] * node.linear->unit_response[l][3 * vertex + k];
        }
        break;
      case Family::modal:
        for (int k = 0; k < 3; ++k) add_modes(model, *node.modal, vertex, k, weights[i], local.rows + k * size);
        break;
    }
  }
}

void local_displacement(const LocalResponse& local, double share, const double* d, std::int32_t n_basis,
                        const double* basis, double* u) {
  for (int i = 0; i < 3; ++i) {
    u[i] = share * local.constant[i] + local.direct * d[i];
    for (std::int32_t j = 0; j < n_basis; ++j) u[i] += local.rows[i * n_basis + j] * basis[j];
  }
}

void field_of_basis(const phn_model& model, const ActiveNode& node, const PreparedNode* prepared, double share,
                    const double* d, const double* basis, double* scratch, double* field) {
  switch (model.family) {
    case Family::rbfn:
      best_network_kernels().field(node.networks->deformation, model.n_output, prepared->gaussians, basis, share,
                                   scratch, field);
      break;
    case Family::linear:
      linear_field(model, *node.linear, basis, field);
      break;
    case Family::modal:
      best_modal_kernels().field(model.shared, *node.modal, prepared, basis, scratch, field);
      break;
  }
  for (std::int32_t p = 0; p < node.n_prescribed; ++p) {
    for (int k = 0; k < 3; ++k) field[3 * node.prescribed[p] + k] = node.prescribed_weight[p] * d[k];
  }
}

void stiffness_at_rest(const phn_model& model, const ActiveNode& node, double* stiffness) {
  if (model.family == Family::linear) {
    const double rest[3] = {0, 0, 0};
    return evaluate_stiffness(model, node, rest, stiffness);
  }
  const double h = model.first_increment;
  double secant[9];
  for (int k = 0; k < 3; ++k) {
    const double to[3] = {k == 0 ? h : 0, k == 1 ? h : 0, k == 2 ? h : 0}, from[3] = {-to[0], -to[1], -to[2]};
    double f[3], g[3];
    evaluate_force(model, node, to, f);
    evaluate_force(model, node, from, g);
    for (int i = 0; i < 3; ++i) secant[3 * i + k] = (f[i] - g[i]) / (2 * h);
  }
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) stiffness[3 * i + k] = (secant[3 * i + k] + secant[3 * k + i]) / 2;
  }
  stiffen(stiffness);
}

}  // namespace phynness::runtime
