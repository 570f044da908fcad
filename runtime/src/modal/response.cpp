#include "modal/response.hpp"

#include "modal/force_kernels.hpp"
#include "modal/modal_kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// Adds one row of a table, times factor[k], to row k of sum. @param sum  3 x m
void add_row(const std::int16_t* row, const double* scale, const double* factor, std::int32_t m, double* sum) {
  for (std::int32_t j = 0; j < m; ++j) {
    const double value = row[j] * scale[j];
    for (int k = 0; k < 3; ++k) sum[k * m + j] += factor[k] * value;
  }
}

/// Derivatives of the amplitudes without the values.
void amplitude_gradient(const phn_model& model, const ModalResponse& node, const double* d, double* gradient,
                        double* scratch) {
  const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis_gradient(model.shared, x, scratch);
  kernels.three_amplitudes(node, model.shared.n_centers + 3, scratch, gradient);
  for (std::int32_t j = 0; j < 3 * node.n_modes; ++j) gradient[j] /= R;
}

}  // namespace

void response_force(const ModalResponse& node, const double* d, double* force) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  best_force_kernels().force(node.force, node.force_table, x, force);
}

double response_energy(const ModalResponse& node, const double* d) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  return best_force_kernels().energy(node.force, node.force_table, x);
}

void response_derivatives(const ModalResponse& node, const double* d, double* force, double* energy,
                          double* stiffness) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  const ForceKernels& kernels = best_force_kernels();
  if (energy == nullptr && stiffness == nullptr) return kernels.force(node.force, node.force_table, x, force);
  auto* derivatives = energy == nullptr      ? kernels.with_stiffness
                      : stiffness == nullptr ? kernels.with_energy
                                             : kernels.with_both;
  double unused;
  derivatives(node.force, node.force_table, x, force, energy == nullptr ? &unused : energy, stiffness);
}

void response_basis(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                    double* scratch) {
  double x[3];
  cut(d, model.max_displacement, largest_modal, x);
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, scratch);
  kernels.amplitudes(node, model.shared.n_centers + 3, scratch, basis);
}

void response_gradient(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                       double* gradient, double* scratch) {
  const double R = model.max_displacement, x[3] = {d[0] / R, d[1] / R, d[2] / R};
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, scratch);
  kernels.amplitudes(node, model.shared.n_centers + 3, scratch, basis);
  amplitude_gradient(model, node, d, gradient, scratch);
}

void response_field(const phn_model& model, const ModalResponse& node, const PreparedNode* prepared, double,
                    const double* basis, double* scratch, double* field) {
  best_modal_kernels().field(model.shared, node, prepared, basis, scratch, field);
}

void prepare_response(const phn_model& model, const ModalResponse& node, PreparedNode& entry) {
  const auto m = static_cast<std::size_t>(node.n_modes), n_shared = static_cast<std::size_t>(model.shared.n_modes);
  const ModalKernels& kernels = best_modal_kernels();
  for (std::size_t row = 0; row < prepared_rows(model); row += rows_per_block)
    kernels.sum_block(model.shared, node, model.shared.modes + row * n_shared, entry.modes + row * m);
  const std::size_t n_near = 3 * static_cast<std::size_t>(node.n_near);
  for (std::size_t r = 0; r < n_near; ++r) {
    for (std::size_t j = 0; j < m; ++j)
      entry.near_mode[j * n_near + r] = node.near_mode[r * m + j] * node.near_mode_scale[j];
  }
}

void ModeSum::add(std::int32_t output, const Matrix& map, LocalResponse& local) {
  const std::int32_t at = find_sorted(_node.near, _node.n_near, output), n_shared = _model.shared.n_modes;
  _mixes = _mixes || at < 0;
  for (std::int32_t c = 0; c < 3; ++c) {
    const auto row = 3 * static_cast<std::size_t>(at >= 0 ? at : output) + static_cast<std::size_t>(c);
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
void ModeSum::finish(LocalResponse& local) const {
  for (std::int32_t s = 0; s < _model.shared.n_modes && _mixes; ++s)
    add_row(_node.mixing + static_cast<std::size_t>(s) * static_cast<std::size_t>(_node.n_columns), _node.mixing_scale,
            _shared + 3 * s, _node.n_modes, local.rows);
}

}  // namespace PHN_RUNTIME
