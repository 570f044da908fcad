// Functions of each family for coupled nodes, in addition to core/families.hpp: derivatives of the basis, and
// displacements of a few vertices as products with the basis.
#pragma once

#include "core/families.hpp"
#include "core/kernels.hpp"
#include "tools/node_field.hpp"

namespace PHN_RUNTIME {

/// The basis and its derivatives: see basis_and_gradient.
inline void response_gradient(const phn_model&, const Networks& nets, const double* d, double* basis, double* gradient,
                              double*) {
  const Network& net = nets.deformation;
  const std::int32_t n = net.n_neurons;
  best_network_kernels().of_inputs(net, 0, d, basis);
  for (std::int32_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) {
      const double y = (d[k] - net.input_center[k]) / net.input_half_range[k] - net.center[k][i];
      gradient[k * n + i] = -2 * y * net.inverse_square_spread / net.input_half_range[k] * basis[i];
    }
}
inline void response_gradient(const phn_model&, const LinearResponse&, const double* d, double* basis, double* gradient,
                              double*) {
  clamp(d, 1, largest_linear, basis);
  for (int i = 0; i < 9; ++i) gradient[i] = i % 4 == 0 ? 1 : 0;
}
inline void response_gradient(const phn_model&, const RestResponse&, const double* d, double* basis, double* gradient,
                              double*) {
  clamp(d, 1, largest_at_rest, basis);
  for (int i = 0; i < 9; ++i) gradient[i] = i % 4 == 0 ? 1 : 0;
}
inline void response_gradient(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                              double* gradient, double* scratch) {
  const double R = model.max_displacement_m, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const std::int32_t n_basis = model.shared.n_centers + 3;
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, scratch);
  kernels.amplitudes(node, n_basis, scratch, basis);
  kernels.basis_gradient(model.shared, x, scratch);
  kernels.three_amplitudes(node, n_basis, scratch, gradient);
  for (std::int32_t j = 0; j < 3 * node.n_modes; ++j) gradient[j] /= R;
}

/// Sums Gaussians over vertices.
class NetworkSum {
 public:
  /// @param gaussian  working memory, n_neurons
  NetworkSum(const phn_model& model, const Networks& nets, double* gaussian)
      : _model(model), _net(nets.deformation), _gaussian(gaussian) {}
  void add(std::int32_t output, const Matrix& map, NodeField& field) const {
    best_network_kernels().of_inputs(_net, 3, _model.output_points + 3 * static_cast<std::size_t>(output), _gaussian);
    for (std::int32_t i = 0; i < _net.n_neurons; ++i) {
      Vector u;
      for (int k = 0; k < 3; ++k)
        u[k] = _gaussian[i] * _net.output_half_range[k] * static_cast<double>(_net.weight[k][i]);
      const Vector sum = map * u;
      for (int k = 0; k < 3; ++k) field.rows[k * _net.n_neurons + i] += sum[k];
    }
    Vector constant;
    for (int k = 0; k < 3; ++k) constant[k] = _net.output_center[k] + _net.output_half_range[k] * _net.bias[k];
    field.constant += map * constant;
  }
  void finish(NodeField&) const {}

 private:
  const phn_model& _model;
  const Network& _net;
  double* _gaussian;
};

/// Sums unit responses over vertices.
class UnitSum {
 public:
  explicit UnitSum(const LinearResponse& linear) : _linear(linear) {}
  void add(std::int32_t output, const Matrix& map, NodeField& field) const {
    for (int l = 0; l < 3; ++l) {
      const Vector u = map * vector_at(_linear.unit_response[l] + 3 * output);
      for (int k = 0; k < 3; ++k) field.rows[3 * k + l] += u[k];
    }
  }
  void finish(NodeField&) const {}

 private:
  const LinearResponse& _linear;
};

/// Sums modes over vertices. Vertices near the node have modes of their own; modes of other vertices are mixed from the
/// shared modes, which are summed first.
class ModeSum {
 public:
  /// @param shared  working memory, n_modes x 3
  ModeSum(const SharedTable& modes, const ModalTables& node, double* shared)
      : _modes(modes), _node(node), _shared(shared) {
    for (std::int32_t k = 0; k < 3 * modes.n_modes; ++k) shared[k] = 0;
  }
  void add(std::int32_t output, const Matrix& map, NodeField& field) {
    const std::int32_t at = find_sorted(_node.near, _node.n_near, output);
    if (at >= 0) return add_near(at, map, field);
    _mixes = true;
    const auto n_shared = static_cast<std::size_t>(_modes.n_modes);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t row = 3 * static_cast<std::size_t>(output) + c;
      const float* mode = _modes.modes + row / rows_per_block * rows_per_block * n_shared + row % rows_per_block;
      for (std::size_t s = 0; s < n_shared; ++s) {
        const auto value = static_cast<double>(mode[s * rows_per_block]);
        for (int k = 0; k < 3; ++k) _shared[3 * s + k] += map(k, static_cast<int>(c)) * value;
      }
    }
  }
  void finish(NodeField& field) const {
    for (std::int32_t s = 0; s < _modes.n_modes && _mixes; ++s)
      add_row(_node.mixing + static_cast<std::size_t>(s) * static_cast<std::size_t>(_node.n_columns),
              _node.mixing_scale, _shared + 3 * s, _node.n_modes, field.rows);
  }

 private:
  void add_near(std::int32_t at, const Matrix& map, NodeField& field) const {
    for (std::int32_t c = 0; c < 3; ++c) {
      const std::size_t row = 3 * static_cast<std::size_t>(at) + static_cast<std::size_t>(c);
      const double factor[3] = {map(0, c), map(1, c), map(2, c)};
      add_row(_node.near_mode + row * static_cast<std::size_t>(_node.n_columns), _node.near_mode_scale, factor,
              _node.n_modes, field.rows);
    }
  }
  /// Adds one row of a table, times factor[k], to row k of sum. @param sum  3 x m
  static void add_row(const std::int16_t* row, const double* scale, const double* factor, std::int32_t m, double* sum) {
    for (std::int32_t j = 0; j < m; ++j) {
      const double value = row[j] * scale[j];
      for (int k = 0; k < 3; ++k) sum[k * m + j] += factor[k] * value;
    }
  }

  const SharedTable& _modes;
  const ModalTables& _node;
  double* _shared;
  bool _mixes = false;
};

inline NetworkSum vertex_sum(const phn_model& model, const Networks& nets, double* scratch) {
  return {model, nets, scratch};
}
inline UnitSum vertex_sum(const phn_model&, const LinearResponse& linear, double*) { return UnitSum(linear); }
inline ModeSum vertex_sum(const phn_model& model, const ModalResponse& node, double* scratch) {
  return {model.shared, node, scratch};
}
inline ModeSum vertex_sum(const phn_model& model, const RestResponse& rest, double* scratch) {
  return {model.rest_modes, rest, scratch};
}

}  // namespace PHN_RUNTIME
