#include "evaluate.hpp"

#include <cmath>

#include "local_response.hpp"
#include "modal.hpp"
#include "network_kernels.hpp"

namespace PHN_RUNTIME {
double length(const double* d) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::fmax(largest, std::fabs(d[k]));
  if (largest > 1e-140 && largest < 1e140) return std::sqrt(dot(d, d));
  if (!(largest > 0) || std::isinf(largest)) return largest;
  // Scaled by a power of two, which is exact, the squares stay in range.
  int exponent = 0;
  std::frexp(largest, &exponent);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double t = std::ldexp(d[k], -exponent);
    sum += t * t;
  }
  return std::ldexp(std::sqrt(sum), exponent);
}

void linear_field(const phn_model& model, const LinearResponse& linear, const double* d, double* field) {
  const double x = d[0], y = d[1], z = d[2];
  const double *ux = linear.unit_response[0], *uy = linear.unit_response[1], *uz = linear.unit_response[2];
  for (std::int32_t i = 0; i < 3 * model.n_output; ++i) field[i] = x * ux[i] + y * uy[i] + z * uz[i];
}

void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force) {
  switch (model.family) {
    case Family::rbfn:
      return best_network_kernels().force(node.networks->force, d, force);
    case Family::linear: {
      double at[3];
      cut(d, 1, largest_linear, at);
      return multiply_symmetric(node.linear->stiffness, at, force);
    }
    case Family::modal:
      return modal_force(*node.modal, d, force);
  }
}

double evaluate_energy(const phn_model& model, const ActiveNode& node, const double* d) {
  if (model.family == Family::modal) return modal_energy(*node.modal, d);
  double at[3], force[3];
  cut(d, 1, largest_linear, at);
  multiply_symmetric(node.linear->stiffness, at, force);
  return dot(at, force) / 2;
}

void evaluate_stiffness(const phn_model& model, const ActiveNode& node, const double* d, double* stiffness) {
  if (model.family == Family::modal) return modal_stiffness(*node.modal, d, stiffness);
  const double* k = node.linear->stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) stiffness[3 * i + j] = stiffness[3 * j + i] = *k++;
  }
}

bool has_energy(const phn_model& model) { return schema::traits(model.family).has_energy; }

bool has_deformation(const phn_model& model, const ActiveNode& node) {
  return model.family != Family::modal || node.modal->n_modes > 0;
}

void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d,
                          double* field) {
  const ActiveNode& node = model.active[active];
  double* basis = data.scratch + model.n_scratch - model.n_basis;
  basis_of(model, node, d, basis, data.scratch);
  field_of_basis(model, node, prepare(model, data.prepared, active), 1, d, basis, data.scratch, field);
}

bool outside(const phn_model& model, const ActiveNode& node, const double* d) {
  if (schema::traits(model.family).proportional) return length(d) > largest_linear;
  // No root for most: squares that overflow or underflow go on below.
  if (dot(d, d) < node.least_depth * node.least_depth) return false;
  const double size = length(d), slack = depth_slack<double>;
  return size > slack * node.least_depth && size > slack * trained_depth(model, node, d);
}

double trained_depth(const phn_model& model, const ActiveNode& node, const double* d) {
  const double size = length(d);
  // Products of these could leave the range of normal numbers.
  const bool extreme = size > 0 && (size < 1e-290 || size > 1e290);
  const double e[3] = {extreme ? d[0] / size : d[0], extreme ? d[1] / size : d[1], extreme ? d[2] / size : d[2]};
  return depth_along(model.directions, node.trained_depth, model.n_directions, e);
}

}  // namespace PHN_RUNTIME
