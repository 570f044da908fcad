// Family linear, and linear points of any family. The basis is the displacement itself.
#include "core/families.hpp"
#include "core/kernels.hpp"

namespace PHN_RUNTIME {

namespace {

void derivatives(const double* k, const double* d, double* force, double* energy, double* stiffness) {
  double at[3];
  clamp(d, 1, largest_linear, at);
  multiply_symmetric(k, at, force);
  if (energy != nullptr) *energy = dot(at, force) / 2;
  if (stiffness != nullptr) fill_symmetric(k, stiffness);
}

}  // namespace

void response_derivatives(const LinearResponse& linear, const double* d, double* force, double* energy,
                          double* stiffness) {
  derivatives(linear.stiffness, d, force, energy, stiffness);
}
void response_derivatives(const RestResponse& rest, const double* d, double* force, double* energy, double* stiffness) {
  derivatives(rest.stiffness, d, force, energy, stiffness);
}

void response_basis(const phn_model&, const RestResponse&, const double* d, double* basis, double*) {
  clamp(d, 1, largest_at_rest, basis);
}

void response_field(const phn_model& model, const RestResponse& rest, const PreparedNode*, double, const double* basis,
                    double* scratch, double* field) {
  best_modal_kernels().field(model.rest_modes, rest, nullptr, basis, scratch, field);
}

void response_basis(const phn_model&, const LinearResponse&, const double* d, double* basis, double*) {
  clamp(d, 1, largest_linear, basis);
}

void response_field(const phn_model& model, const LinearResponse& linear, const PreparedNode*, double,
                    const double* basis, double*, double* field) {
  const double x = basis[0], y = basis[1], z = basis[2];
  const double *ux = linear.unit_response[0], *uy = linear.unit_response[1], *uz = linear.unit_response[2];
  for (std::int32_t i = 0; i < 3 * model.n_output; ++i) field[i] = x * ux[i] + y * uy[i] + z * uz[i];
}

}  // namespace PHN_RUNTIME
