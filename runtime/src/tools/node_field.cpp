#include "tools/node_field.hpp"

#include <cmath>

#include "tools/family_sums.hpp"

namespace PHN_RUNTIME {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i)
    if (list[i] == value) return i;
  return -1;
}

/// Smallest determinant of a stiffness at rest over the cube of its mean diagonal. Values from 0 to 0.05 give the same
/// forces between nodes.
constexpr double least_determinant = 0.01;

/// Adds a multiple of the identity to a symmetric matrix until it is positive definite. Near a snap-through fits at
/// rest are not, and the response of a point between such nodes would be a difference of large numbers.
void make_positive_definite(Matrix& stiffness) {
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

/// Step [m] of differences of forces around rest.
double step_at_rest(const phn_model& model, const ActiveNode& node) {
  constexpr double of_round_tools = 0.3;
  return node.moves_mean ? of_round_tools * model.first_increment : model.first_increment;
}

}  // namespace

void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch,
                            double* other) {
  const std::int32_t n = basis_size(model, node);
  const double h = schema::traits(model.kind).proportional ? 1 : model.first_increment;
  for (int k = 0; k < 3; ++k) {
    basis_of(model, node, unit_vector(k, h).x, gradient + k * n, scratch);
    basis_of(model, node, (-1 * unit_vector(k, h)).x, other, scratch);
    for (std::int32_t j = 0; j < n; ++j) gradient[k * n + j] = (gradient[k * n + j] - other[j]) / (2 * h);
  }
}

void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch) {
  with_response(model, node,
                [&](const auto& response) { response_gradient(model, response, d, basis, gradient, scratch); });
}

void clear(const phn_model& model, const ActiveNode& node, NodeField& field) {
  field.constant = {};
  field.direct = {};
  for (std::int32_t i = 0; i < 3 * basis_size(model, node); ++i) field.rows[i] = 0;
}

void add_vertices(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
                  const Matrix* maps, double* scratch, NodeField& field) {
  with_response(model, node, [&](const auto& response) {
    auto sum = vertex_sum(model, response, scratch);
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t vertex = vertices[i];
      if (vertex < 0 || vertex >= model.n_output) continue;
      const std::int32_t moved = node.moves_mean ? -1 : position_of(node.prescribed, node.n_prescribed, vertex);
      if (moved >= 0) {
        field.direct += node.prescribed_weight[moved] * maps[i];
      } else {
        sum.add(vertex, maps[i], field);
      }
    }
    sum.finish(field);
  });
}

Vector displacement_of(const NodeField& field, double share, const Vector& d, std::int32_t n_basis,
                       const double* basis) {
  Vector u = field.direct * d;
  for (int i = 0; i < 3; ++i) {
    u[i] += share * field.constant[i];
    for (std::int32_t j = 0; j < n_basis; ++j) u[i] += field.rows[i * n_basis + j] * basis[j];
  }
  return u;
}

double nonlinearity(const phn_model& model, const ActiveNode& node, const Matrix& stiffness) {
  double difference = 0, all = 0;
  for (int k = 0; k < 6; ++k) {
    const Vector d = unit_vector(k / 2, (k % 2 - 0.5) * 2 * model.max_displacement_m), linear = stiffness * d;
    Vector force;
    evaluate_force(model, node, d.x, force.x);
    force -= linear;
    difference += dot(force, force);
    all += dot(linear, linear);
  }
  return all > 0 ? difference / all : 0;
}

Matrix stiffness_at_rest(const phn_model& model, const ActiveNode& node) {
  Matrix secant;
  if (schema::traits(model.kind).proportional) {
    Vector none;
    evaluate_force(model, node, Vector{}.x, none.x, nullptr, secant.a);
    return secant;
  }
  const double h = step_at_rest(model, node);
  for (int k = 0; k < 3; ++k) {
    Vector f, g;
    evaluate_force(model, node, unit_vector(k, h).x, f.x);
    evaluate_force(model, node, (-1 * unit_vector(k, h)).x, g.x);
    for (int i = 0; i < 3; ++i) secant(i, k) = (f[i] - g[i]) / (2 * h);
  }
  Matrix stiffness = symmetric_part(secant);
  make_positive_definite(stiffness);
  return stiffness;
}

}  // namespace PHN_RUNTIME
