#include "local_response.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "modal_kernels.hpp"
#include "network_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (list[i] == value) return i;
  }
  return -1;
}

/// Adds one row of a table to three, times `factor`. @param sum  3 x m
void add_row(const std::int16_t* row, const double* scale, const double* factor, std::int32_t m, double* sum) {
  for (std::int32_t j = 0; j < m; ++j) {
    const double value = row[j] * scale[j];
    for (int k = 0; k < 3; ++k) sum[k * m + j] += factor[k] * value;
  }
}

/// Modes of vertices near the node are its own, those of others mixed from the shared ones, which are summed
/// first.
class ModeSum {
 public:
  ModeSum(const phn_model& model, const ModalResponse& node, double* shared)
      : _model(model), _node(node), _shared(shared) {
    for (std::int32_t k = 0; k < 3 * model.shared.n_modes; ++k) shared[k] = 0;
  }
  void add(std::int32_t output, const Matrix& map, LocalResponse& local) {
    const std::int32_t at = find_sorted(_node.near, _node.n_near, output), n_shared = _model.shared.n_modes;
    _mixes = _mixes || at < 0;
    for (std::int32_t c = 0; c < 3; ++c) {
      const auto row = static_cast<std::size_t>(3 * (at >= 0 ? at : output) + c);
      const double factor[3] = {map(0, c), map(1, c), map(2, c)};
      if (at >= 0) {
        add_row(_node.near_mode + row * static_cast<std::size_t>(_node.n_columns), _node.near_mode_scale, factor,
                _node.n_modes, local.rows);
        continue;
      }
      const float* mode = _model.shared.modes +
                          row / rows_per_block * rows_per_block * static_cast<std::size_t>(n_shared) +
                          row % rows_per_block;
      for (std::int32_t s = 0; s < n_shared; ++s) {
        const auto value = static_cast<double>(mode[s * rows_per_block]);
        for (int k = 0; k < 3; ++k) _shared[3 * s + k] += factor[k] * value;
      }
    }
  }
  void mix(LocalResponse& local) const {
    for (std::int32_t s = 0; s < _model.shared.n_modes && _mixes; ++s)
      add_row(_node.mixing + static_cast<std::size_t>(s) * static_cast<std::size_t>(_node.n_columns),
              _node.mixing_scale, _shared + 3 * s, _node.n_modes, local.rows);
  }

 private:
  const phn_model& _model;
  const ModalResponse& _node;
  double* _shared;  ///< n_modes x 3
  bool _mixes = false;
};

void add_gaussians(const phn_model& model, const Network& net, std::int32_t output, const Matrix& map, double* gaussian,
                   LocalResponse& local) {
  best_network_kernels().of_inputs(net, 3, model.output_points + 3 * static_cast<std::size_t>(output), gaussian);
  for (std::int32_t i = 0; i < net.n_neurons; ++i) {
    Vector u;
    for (int k = 0; k < 3; ++k) u[k] = gaussian[i] * net.output_half_range[k] * static_cast<double>(net.weight[k][i]);
    const Vector sum = map * u;
    for (int k = 0; k < 3; ++k) local.rows[k * net.n_neurons + i] += sum[k];
  }
  Vector constant;
  for (int k = 0; k < 3; ++k) constant[k] = net.output_center[k] + net.output_half_range[k] * net.bias[k];
  local.constant += map * constant;
}

/// Of a stiffness at rest, over the cube of its mean diagonal. Forces between nodes are the same from 0 to
/// 0.05.
constexpr double least_determinant = 0.01;

/// Raises a symmetric matrix by a multiple of 1 until it resists in every direction: beside a snap fits at
/// rest do not, and what a point between such nodes does is then the difference of large numbers.
void stiffen(Matrix& stiffness) {
  double* k = stiffness.a;
  const double mean = (std::fabs(k[0]) + std::fabs(k[4]) + std::fabs(k[8])) / 3, shift = mean / 16;
  const double d[3] = {k[0], k[4], k[8]};
  for (int step = 0; step < 64; ++step) {
    const double second = k[0] * k[4] - k[1] * k[1];
    const double third =
        k[0] * (k[4] * k[8] - k[5] * k[5]) - k[1] * (k[1] * k[8] - k[5] * k[2]) + k[2] * (k[1] * k[5] - k[4] * k[2]);
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
      return best_network_kernels().of_inputs(node.networks->deformation, 0, d, basis);
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
    basis_of(model, node, unit_vector(k, h).x, gradient + k * n, scratch);
    basis_of(model, node, (-1 * unit_vector(k, h)).x, other, scratch);
    for (std::int32_t j = 0; j < n; ++j) gradient[k * n + j] = (gradient[k * n + j] - other[j]) / (2 * h);
  }
}

void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch) {
  const std::int32_t n = basis_size(model, node);
  switch (model.family) {
    case Family::rbfn: {
      const Network& net = node.networks->deformation;
      best_network_kernels().of_inputs(net, 0, d, basis);
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

void clear_local(const phn_model& model, const ActiveNode& node, LocalResponse& local) {
  local.constant = {};
  local.direct = {};
  for (std::int32_t i = 0; i < 3 * basis_size(model, node); ++i) local.rows[i] = 0;
}

void add_local(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
               const Matrix* maps, double* scratch, LocalResponse& local) {
  const bool modal = model.family == Family::modal;
  // Other families share no modes, and have no node to mix them for.
  static const ModalResponse none = {};
  ModeSum modes(model, modal ? *node.modal : none, scratch);
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t vertex = vertices[i];
    const Matrix& map = maps[i];
    if (vertex < 0 || vertex >= model.n_output) continue;
    const std::int32_t moved = position_of(node.prescribed, node.n_prescribed, vertex);
    if (moved >= 0) {
      local.direct += node.prescribed_weight[moved] * map;
    } else if (modal) {
      modes.add(vertex, map, local);
    } else if (model.family == Family::rbfn) {
      add_gaussians(model, node.networks->deformation, vertex, map, scratch, local);
    } else {
      for (int l = 0; l < 3; ++l) {
        const Vector u = map * vector_at(node.linear->unit_response[l] + 3 * vertex);
        for (int k = 0; k < 3; ++k) local.rows[3 * k + l] += u[k];
      }
    }
  }
  if (modal) modes.mix(local);
}

Vector local_displacement(const LocalResponse& local, double share, const Vector& d, std::int32_t n_basis,
                          const double* basis) {
  Vector u = local.direct * d;
  for (int i = 0; i < 3; ++i) {
    u[i] += share * local.constant[i];
    for (std::int32_t j = 0; j < n_basis; ++j) u[i] += local.rows[i * n_basis + j] * basis[j];
  }
  return u;
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

double curvature(const phn_model& model, const ActiveNode& node, const Matrix& stiffness) {
  double apart = 0, all = 0;
  for (int k = 0; k < 6; ++k) {
    const Vector d = unit_vector(k / 2, (k % 2 - 0.5) * 2 * model.max_displacement), linear = stiffness * d;
    Vector force;
    evaluate_force(model, node, d.x, force.x);
    force -= linear;
    apart += dot(force, force);
    all += dot(linear, linear);
  }
  return all > 0 ? apart / all : 0;
}

Matrix stiffness_at_rest(const phn_model& model, const ActiveNode& node) {
  Matrix secant;
  if (model.family == Family::linear) {
    evaluate_stiffness(model, node, Vector{}.x, secant.a);
    return secant;
  }
  const double h = model.first_increment;
  for (int k = 0; k < 3; ++k) {
    Vector f, g;
    evaluate_force(model, node, unit_vector(k, h).x, f.x);
    evaluate_force(model, node, (-1 * unit_vector(k, h)).x, g.x);
    for (int i = 0; i < 3; ++i) secant(i, k) = (f[i] - g[i]) / (2 * h);
  }
  Matrix stiffness = symmetric_part(secant);
  stiffen(stiffness);
  return stiffness;
}

}  // namespace PHN_RUNTIME
