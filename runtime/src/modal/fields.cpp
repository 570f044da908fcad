// Scalar fields beside the deformation (formats/model.md, "Fields").
#include <cmath>

#include "modal/modal_kernels.hpp"
#include "modal/response.hpp"

namespace PHN_RUNTIME {
namespace {

/// e_jk = x_j x_k |x|^(degree - 2); 0 at x = 0.
void even_basis(const double* x, std::int32_t degree, double* e) {
  const double size = std::sqrt(dot(x, x));
  const double by = degree == 2 ? 1 : size > 0 ? 1 / size : 0;
  for (int j = 0; j < 3; ++j) {
    for (int k = j; k < 3; ++k) *e++ = x[j] * x[k] * by;
  }
}

}  // namespace

void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out) {
  const SharedField& shared = model.fields[field];
  const ModalTables& tables = node.fields[field];
  const std::int32_t n_centers = model.shared.n_centers, n_basis = n_centers + schema::n_field_terms;
  double x[3], *basis = scratch, *amplitude = basis + n_basis;
  cut(d, model.max_displacement, largest_modal, x);
  const ModalKernels& kernels = best_modal_kernels();
  kernels.basis(model.shared, x, basis);
  even_basis(x, shared.degree, basis + n_centers + 3);
  kernels.amplitudes(tables, n_basis, basis, amplitude);
  kernels.field(shared, tables, nullptr, amplitude, amplitude + tables.n_modes, out);
  for (std::int32_t o = 0; o < model.n_output; ++o) out[o] = std::fmax(0.0, shared.scale * out[o]);
}

}  // namespace PHN_RUNTIME
