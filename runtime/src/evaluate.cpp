#include "evaluate.hpp"

#include <cmath>

#include "families.hpp"

namespace PHN_RUNTIME {

double length(const double* d) {
  double largest = 0;
  for (int k = 0; k < 3; ++k) largest = std::fmax(largest, std::fabs(d[k]));
  if (largest > 1e-140 && largest < 1e140) return std::sqrt(dot(d, d));
  if (!(largest > 0) || std::isinf(largest)) return largest;
  // Scaling by a power of two is exact and keeps the squares in range.
  int exponent = 0;
  std::frexp(largest, &exponent);
  double sum = 0;
  for (int k = 0; k < 3; ++k) {
    const double t = std::ldexp(d[k], -exponent);
    sum += t * t;
  }
  return std::ldexp(std::sqrt(sum), exponent);
}

void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force) {
  with_response(model, node, [&](const auto& response) { response_force(response, d, force); });
}

double evaluate_energy(const phn_model& model, const ActiveNode& node, const double* d) {
  return with_response(model, node, [&](const auto& response) { return response_energy(response, d); });
}

void evaluate_derivatives(const phn_model& model, const ActiveNode& node, const double* d, double* force,
                          double* energy, double* stiffness) {
  with_response(model, node,
                [&](const auto& response) { response_derivatives(response, d, force, energy, stiffness); });
}

bool has_energy(const phn_model& model) { return schema::traits(model.family).has_energy; }

bool has_deformation(const phn_model& model, const ActiveNode& node) {
  return with_response(model, node, [](const auto& response) { return has_deformation(response); });
}

void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d, double* field) {
  const ActiveNode& node = model.active[active];
  double* basis = data.scratch + model.n_scratch - model.n_basis;
  basis_of(model, node, d, basis, data.scratch);
  field_of_basis(model, node, prepare(model, data.prepared, active), 1, d, basis, data.scratch, field);
}

bool outside(const phn_model& model, const ActiveNode& node, const double* d) {
  if (schema::traits(model.family).proportional) return length(d) > largest_linear;
  // Most displacements need no square root. Squares that overflow or underflow are handled below.
  if (dot(d, d) < node.least_depth * node.least_depth) return false;
  const double size = length(d), slack = depth_slack<double>;
  return size > slack * node.least_depth && size > slack * trained_depth(model, node, d);
}

double trained_depth(const phn_model& model, const ActiveNode& node, const double* d) {
  const double size = length(d);
  // Products of such numbers could be subnormal or infinite.
  const bool extreme = size > 0 && (size < 1e-290 || size > 1e290);
  const double e[3] = {extreme ? d[0] / size : d[0], extreme ? d[1] / size : d[1], extreme ? d[2] / size : d[2]};
  return depth_along(model.directions, node.trained_depth, model.n_directions, e, extreme ? 1 : size,
                     model.max_displacement);
}

}  // namespace PHN_RUNTIME
