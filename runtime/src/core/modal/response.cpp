// Family modal: conservative forces, modes and fields (formats/model.md, "Family `modal`"). Components of d are clamped
// to 1e6 max_displacement_m.
#include "core/families.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {
namespace {

/// e_jk = x_j x_k |x|^(degree - 2); 0 at x = 0.
void even_basis(const double* x, std::int32_t degree, double* e) {
  const double size = std::sqrt(dot(x, x));
  const double by = degree == 2 ? 1 : size > 0 ? 1 / size : 0;
  for (int j = 0; j < 3; ++j)
    for (int k = j; k < 3; ++k) *e++ = x[j] * x[k] * by;
}

}  // namespace

void response_derivatives(const ModalResponse& node, const double* d, double* force, double* energy,
                          double* stiffness) {
  double x[3];
  clamp(d, node.force.max_displacement, largest_modal, x);
  const ForceKernels& kernels = best_force_kernels();
  double unused;
  if (stiffness == nullptr)
    (energy == nullptr ? kernels.force : kernels.with_energy)(node.force, x, force, energy, nullptr);
  else
    (energy == nullptr ? kernels.with_stiffness : kernels.with_both)(node.force, x, force, energy ? energy : &unused,
                                                                     stiffness);
}

void response_basis(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                    double* scratch) {
  double x[3];
  clamp(d, model.max_displacement_m, largest_modal, x);
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, scratch);
  kernels.amplitudes(node, model.shared.n_centers + 3, scratch, basis);
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
  for (std::size_t r = 0; r < n_near; ++r)
    for (std::size_t j = 0; j < m; ++j)
      entry.near_mode[j * n_near + r] = node.near_mode[r * m + j] * node.near_mode_scale[j];
}

void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out) {
  const SharedField& shared = model.fields[field];
  const ModalTables& tables = node.fields[field];
  const std::int32_t n_centers = model.shared.n_centers, n_basis = n_centers + schema::n_field_terms;
  double x[3], *basis = scratch, *amplitude = basis + n_basis;
  clamp(d, model.max_displacement_m, largest_modal, x);
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, basis);
  even_basis(x, shared.degree, basis + n_centers + 3);
  kernels.amplitudes(tables, n_basis, basis, amplitude);
  kernels.field(shared, tables, nullptr, amplitude, amplitude + tables.n_modes, out);
  for (std::int32_t o = 0; o < model.n_output; ++o) out[o] = std::fmax(0.0, shared.scale * out[o]);
}

}  // namespace PHN_RUNTIME
