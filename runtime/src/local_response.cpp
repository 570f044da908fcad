#include "local_response.hpp"

#include <cmath>

#include "evaluate.hpp"

namespace phynness::runtime {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (list[i] == value) return i;
  }
  return -1;
}

bool within(const double* d, double largest) {
  return std::fabs(d[0]) <= largest && std::fabs(d[1]) <= largest && std::fabs(d[2]) <= largest;
}

/// basis_i = exp(-|x - c_i|^2 / r^2) over the displacement's three inputs.
void gaussian_basis(const Network& net, const double* d, double* basis, double* gradient) {
  const std::int32_t n = net.n_neurons;
  double x[3];
  for (int k = 0; k < 3; ++k) x[k] = (d[k] - net.input_center[k]) / net.input_half_range[k];
  for (std::int32_t i = 0; i < n; ++i) {
    double y[3], square = 0;
    for (int k = 0; k < 3; ++k) {
      y[k] = x[k] - net.center[k][i];
      square += y[k] * y[k];
    }
    basis[i] = std::exp(-square * net.inverse_square_spread);
    for (int k = 0; k < 3; ++k)
      gradient[k * n + i] = -2 * y[k] * net.inverse_square_spread / net.input_half_range[k] * basis[i];
  }
}

void amplitudes(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                double* gradient, double* scratch) {
  const SharedModes& shared = model.shared;
  const std::int32_t m = node.n_modes, n = shared.n_centers;
  const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const double s2 = shared.shape * shared.shape, q0 = std::sqrt(dot(x, x) + s2);
  // Value and gradient of each kernel, then of the three linear terms.
  for (std::int32_t i = 0; i < n; ++i) {
    const double* c = model.displacements + 3 * static_cast<std::size_t>(shared.center[i]);
    const double y[3] = {x[0] - c[0], x[1] - c[1], x[2] - c[2]}, q = std::sqrt(dot(y, y) + s2);
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

void add_row(const std::int16_t* row, const double* scale, double weight, std::int32_t m, double* sum) {
  for (std::int32_t j = 0; j < m; ++j) sum[j] += weight * (row[j] * scale[j]);
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

bool local_basis(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                 double* gradient, double* scratch) {
  switch (model.family) {
    case Family::rbfn:
      gaussian_basis(node.networks->deformation, d, basis, gradient);
      return true;
    case Family::modal:
      amplitudes(model, *node.modal, d, basis, gradient, scratch);
      return within(d, largest_modal * model.max_displacement);
    case Family::linear:
      break;
  }
  for (int k = 0; k < 3; ++k) {
    basis[k] = d[k];
    for (int l = 0; l < 3; ++l) gradient[3 * k + l] = k == l ? 1 : 0;
  }
  return within(d, largest_linear);
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
        for (int k = 0; k < 3; ++k)
          add_modes(model, *node.modal, vertex, k, weights[i], local.rows + k * size);
        break;
    }
  }
}

void local_displacement(const LocalResponse& local, std::int32_t n_basis, const double* d, const double* basis,
                        const double* gradient, double* u, double* jacobian) {
  for (int i = 0; i < 3; ++i) {
    const double* row = local.rows + i * n_basis;
    double sum[4] = {};
    for (std::int32_t j = 0; j < n_basis; ++j) {
      sum[0] += row[j] * basis[j];
      for (int k = 0; k < 3; ++k) sum[1 + k] += row[j] * gradient[k * n_basis + j];
    }
    u[i] = local.constant[i] + local.direct * d[i] + sum[0];
    for (int k = 0; k < 3; ++k) jacobian[3 * i + k] = sum[1 + k] + (i == k ? local.direct : 0);
  }
}

void force_jacobian(const phn_model& model, const ActiveNode& node, const double* d, double* stiffness) {
  if (has_energy(model)) return evaluate_stiffness(model, node, d, stiffness);
  const Network& net = node.networks->force;
  double x[3];
  for (int k = 0; k < 3; ++k) x[k] = (d[k] - net.input_center[k]) / net.input_half_range[k];
  for (int i = 0; i < 9; ++i) stiffness[i] = 0;
  for (std::int32_t i = 0; i < net.n_neurons; ++i) {
    double y[3], square = 0;
    for (int k = 0; k < 3; ++k) {
      y[k] = x[k] - net.center[k][i];
      square += y[k] * y[k];
    }
    const double h = -2 * net.inverse_square_spread * std::exp(-square * net.inverse_square_spread);
    for (int r = 0; r < 3; ++r) {
      const double w = net.output_half_range[r] * net.weight[r][i] * h;
      for (int c = 0; c < 3; ++c) stiffness[3 * r + c] += w * y[c] / net.input_half_range[c];
    }
  }
}

}  // namespace phynness::runtime
