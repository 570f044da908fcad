#include "linear/response.hpp"

namespace PHN_RUNTIME {

void response_force(const LinearResponse& linear, const double* d, double* force) {
  double at[3];
  cut(d, 1, largest_linear, at);
  multiply_symmetric(linear.stiffness, at, force);
}

double response_energy(const LinearResponse& linear, const double* d) {
  double at[3], force[3];
  cut(d, 1, largest_linear, at);
  multiply_symmetric(linear.stiffness, at, force);
  return dot(at, force) / 2;
}

void response_derivatives(const LinearResponse& linear, const double* d, double* force, double* energy,
                          double* stiffness) {
  double at[3];
  cut(d, 1, largest_linear, at);
  multiply_symmetric(linear.stiffness, at, force);
  if (energy != nullptr) *energy = dot(at, force) / 2;
  if (stiffness == nullptr) return;
  const double* k = linear.stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) stiffness[3 * i + j] = stiffness[3 * j + i] = *k++;
  }
}

void response_basis(const phn_model&, const LinearResponse&, const double* d, double* basis, double*) {
  cut(d, 1, largest_linear, basis);
}

void response_gradient(const phn_model& model, const LinearResponse& linear, const double* d, double* basis,
                       double* gradient, double* scratch) {
  response_basis(model, linear, d, basis, scratch);
  for (int i = 0; i < 9; ++i) gradient[i] = i % 4 == 0 ? 1 : 0;
}

void response_field(const phn_model& model, const LinearResponse& linear, const PreparedNode*, double,
                    const double* basis, double*, double* field) {
  const double x = basis[0], y = basis[1], z = basis[2];
  const double *ux = linear.unit_response[0], *uy = linear.unit_response[1], *uz = linear.unit_response[2];
  for (std::int32_t i = 0; i < 3 * model.n_output; ++i) field[i] = x * ux[i] + y * uy[i] + z * uz[i];
}

void UnitSum::add(std::int32_t output, const Matrix& map, LocalResponse& local) const {
  for (int l = 0; l < 3; ++l) {
    const Vector u = map * vector_at(_linear.unit_response[l] + 3 * output);
    for (int k = 0; k < 3; ++k) local.rows[3 * k + l] += u[k];
  }
}

}  // namespace PHN_RUNTIME
