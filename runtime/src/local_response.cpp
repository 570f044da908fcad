#include "local_response.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "modal_kernels.hpp"

namespace phynness::runtime {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (list[i] == value) return i;
  }
  return -1;
}

double cut(double value, double largest) { return std::fmax(-largest, std::fmin(largest, value)); }

/// exp(-|x - c_i|^2 / r^2) over the displacement's three inputs.
void gaussians(const Network& net, const double* d, double* basis) {
  double x[3];
  for (int k = 0; k < 3; ++k) x[k] = (d[k] - net.input_center[k]) / net.input_half_range[k];
  for (std::int32_t i = 0; i < net.n_neurons; ++i) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += (x[k] - net.center[k][i]) * (x[k] - net.center[k][i]);
    basis[i] = std::exp(-square * net.inverse_square_spread);
  }
}

void gaussian_gradient_at_rest(const Network& net, double* gradient) {
  const double rest[3] = {0, 0, 0};
  gaussians(net, rest, gradient);
  const std::int32_t n = net.n_neurons;
  for (std::int32_t i = 0; i < n; ++i) {
    const double h = gradient[i];
    for (int k = 0; k < 3; ++k) {
      const double y = -net.input_center[k] / net.input_half_range[k] - net.center[k][i];
      gradient[k * n + i] = -2 * y * net.inverse_square_spread / net.input_half_range[k] * h;
    }
  }
}

/// amplitudes = weights^T kernel, kernel of n_centers + 3 values.
void amplitudes_of(const phn_model& model, const ModalResponse& node, const double* kernel, double* amplitude) {
  const std::int32_t m = node.n_modes;
  for (std::int32_t j = 0; j < m; ++j) amplitude[j] = 0;
  for (std::int32_t r = 0; r < model.shared.n_centers + 3; ++r) {
    const std::int16_t* row = node.weight + static_cast<std::size_t>(r) * static_cast<std::size_t>(m);
    for (std::int32_t j = 0; j < m; ++j) amplitude[j] += kernel[r] * row[j];
  }
  for (std::int32_t j = 0; j < m; ++j) amplitude[j] *= node.weight_scale[j];
}

void modal_amplitudes_and_gradient(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                                   double* gradient, double* scratch) {
  const SharedModes& shared = model.shared;
  const std::int32_t m = node.n_modes, n = shared.n_centers;
  const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const double s2 = shared.shape * shared.shape, q0 = std::sqrt(dot(x, x) + s2);
  // Value and gradient of each kernel, then of the three linear terms.
  for (std::int32_t i = 0; i < n; ++i) {
    const double y[3] = {x[0] - shared.center[0][i], x[1] - shared.center[1][i], x[2] - shared.center[2][i]};
    const double q = std::sqrt(dot(y, y) + s2);
    double* kernel = scratch + 4 * i;
    kernel[0] = (q - q0) - shared.basis_at_rest[i];
    for (int k = 0; k < 3; ++k) kernel[1 + k] = (y[k] / q - x[k] / q0) / R;
  }
  for (int k = 0; k < 3; ++k) {
    double* kernel = scratch + 4 * (n + k);
    kernel[0] = x[k];
    for (int l = 0; l < 3; ++l) kernel[1 + l] = k == l ? 1 / R : 0;
  }
  for (std::int32_t j = 0; j < m; ++j) basis[j] = gradient[j] = gradient[m + j] = gradient[2 * m + j] = 0;
  for (std::int32_t r = 0; r < n + 3; ++r) {
    const double* kernel = scratch + 4 * r;
    const std::int16_t* row = node.weight + static_cast<std::size_t>(r) * static_cast<std::size_t>(m);
    for (std::int32_t j = 0; j < m; ++j) {
      const double w = row[j];
      basis[j] += kernel[0] * w;
      gradient[j] += kernel[1] * w;
      gradient[m + j] += kernel[2] * w;
      gradient[2 * m + j] += kernel[3] * w;
    }
  }
  for (std::int32_t j = 0; j < m; ++j) {
    basis[j] *= node.weight_scale[j];
    for (int k = 0; k < 3; ++k) gradient[k * m + j] *= node.weight_scale[j];
  }
}

void add_row(const std::int16_t* row, const double* scale, double factor, std::int32_t m, double* sum) {
  for (std::int32_t j = 0; j < m; ++j) sum[j] += factor * (row[j] * scale[j]);
}

/// One component of one output node's displacement, per amplitude.
void add_modes(const phn_model& model, const ModalResponse& node, std::int32_t output, int component,
               double weight, double* sum) {
  const auto m = static_cast<std::size_t>(node.n_modes);
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
      return gaussians(node.networks->deformation, d, basis);
    case Family::linear:
      for (int k = 0; k < 3; ++k) basis[k] = cut(d[k], largest_linear);
      return;
    case Family::modal: {
      double x[3];
      for (int k = 0; k < 3; ++k) x[k] = cut(d[k] / model.max_displacement, largest_modal);
      return best_modal_kernels().amplitudes(model, *node.modal, x, scratch, basis);
    }
  }
}

void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch) {
  const std::int32_t n = basis_size(model, node);
  switch (model.family) {
    case Family::rbfn:
      return gaussian_gradient_at_rest(node.networks->deformation, gradient);
    case Family::linear:
      for (int i = 0; i < 9; ++i) gradient[i] = i % 4 == 0 ? 1 : 0;
      return;
    case Family::modal: {
      const SharedModes& shared = model.shared;
      for (int k = 0; k < 3; ++k) {
        for (std::int32_t i = 0; i < shared.n_centers; ++i) {
          const double c[3] = {shared.center[0][i], shared.center[1][i], shared.center[2][i]};
          scratch[i] = -c[k] / std::sqrt(dot(c, c) + shared.shape * shared.shape) / model.max_displacement;
        }
        for (int l = 0; l < 3; ++l) scratch[shared.n_centers + l] = k == l ? 1 / model.max_displacement : 0;
        amplitudes_of(model, *node.modal, scratch, gradient + k * n);
      }
      return;
    }
  }
}

void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch) {
  const std::int32_t n = basis_size(model, node);
  switch (model.family) {
    case Family::rbfn: {
      const Network& net = node.networks->deformation;
      gaussians(net, d, basis);
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
      return basis_gradient_at_rest(model, node, gradient, scratch);
    case Family::modal:
      return modal_amplitudes_and_gradient(model, *node.modal, d, basis, gradient, scratch);
  }
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
      network_field(model, node.networks->deformation, basis, share, field);
      break;
    case Family::linear:
      linear_field(model, *node.linear, basis, field);
      break;
    case Family::modal:
      best_modal_kernels().field(model, *node.modal, prepared, basis, scratch, field);
      break;
  }
  for (std::int32_t p = 0; p < node.n_prescribed; ++p) {
    for (int k = 0; k < 3; ++k) field[3 * node.prescribed[p] + k] = node.prescribed_weight[p] * d[k];
  }
}

void stiffness_at_rest(const phn_model& model, const ActiveNode& node, double* stiffness) {
  const double rest[3] = {0, 0, 0};
  if (has_energy(model)) return evaluate_stiffness(model, node, rest, stiffness);
  const Network& net = node.networks->force;
  for (int i = 0; i < 9; ++i) stiffness[i] = 0;
  for (std::int32_t i = 0; i < net.n_neurons; ++i) {
    double y[3], square = 0;
    for (int k = 0; k < 3; ++k) {
      y[k] = -net.input_center[k] / net.input_half_range[k] - net.center[k][i];
      square += y[k] * y[k];
    }
    const double h = -2 * net.inverse_square_spread * std::exp(-square * net.inverse_square_spread);
    for (int r = 0; r < 3; ++r) {
      const double w = net.output_half_range[r] * net.weight[r][i] * h;
      for (int c = 0; c < 3; ++c) {
        stiffness[3 * r + c] += w * y[c] / net.input_half_range[c] / 2;
        stiffness[3 * c + r] += w * y[c] / net.input_half_range[c] / 2;
      }
    }
  }
}

}  // namespace phynness::runtime
