#include "tools/local_response.hpp"

#include <cmath>

#include "tools/family_sums.hpp"

namespace PHN_RUNTIME {
namespace {

std::int32_t position_of(const std::int32_t* list, std::int32_t n, std::int32_t value) {
  for (std::int32_t i = 0; i < n; ++i) {
    if (list[i] == value) return i;
  }
  return -1;
}

/// Smallest determinant of a stiffness at rest over the cube of its mean diagonal. Values from 0 to 0.05 give the same
/// forces between nodes.
constexpr double least_determinant = 0.01;

/// Adds a multiple of the identity to a symmetric matrix until it is positive definite. Near a snap-through fits at
/// rest are not, and the response of a point between such nodes would be a difference of large numbers.
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

/// Step [m] of differences around rest. Round tools that are near each other multiply what they get wrong, so that the
/// curvature over the whole first increment counts (docs/decisions/several-round-tools.md).
double step_at_rest(const phn_model& model, const ActiveNode& node) {
  constexpr double of_round_tools = 0.3;
  return node.moves_mean ? of_round_tools * model.first_increment : model.first_increment;
}

}  // namespace

void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch,
                            double* other) {
  const std::int32_t n = basis_size(model, node);
  const double h = schema::traits(model.kind).proportional ? 1 : step_at_rest(model, node);
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

void clear_local(const phn_model& model, const ActiveNode& node, LocalResponse& local) {
  local.constant = {};
  local.direct = {};
  for (std::int32_t i = 0; i < 3 * basis_size(model, node); ++i) local.rows[i] = 0;
}

void add_local(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
               const Matrix* maps, double* scratch, LocalResponse& local) {
  with_response(model, node, [&](const auto& response) {
    auto sum = vertex_sum(model, response, scratch);
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t vertex = vertices[i];
      if (vertex < 0 || vertex >= model.n_output) continue;
      const std::int32_t moved = node.moves_mean ? -1 : position_of(node.prescribed, node.n_prescribed, vertex);
      if (moved >= 0) {
        local.direct += node.prescribed_weight[moved] * maps[i];
      } else {
        sum.add(vertex, maps[i], local);
      }
    }
    sum.finish(local);
  });
}

void add_round_tool(const ActiveNode& node, double part, double* weight) {
  for (std::int32_t m = 0; m < node.n_prescribed; ++m) weight[node.prescribed[m]] += part * node.prescribed_weight[m];
}

void sum_shared(const phn_model& model, const double* weight, double* shared) {
  for (std::int32_t k = 0; k < 3 * model.shared.n_modes; ++k) shared[k] = 0;
  for (std::int32_t v = 0; v < model.n_output; ++v) {
    if (weight[v] != 0) add_shared(model, v, weight[v], shared);
  }
}

void mean_response(const phn_model& model, const ActiveNode& node, double own, double* weight, const double* shared,
                   double* scratch, LocalResponse& local) {
  clear_local(model, node, local);
  local.direct = diagonal(own);
  if (own == 1) return;
  if (own != 0) add_round_tool(node, -own, weight);
  for (std::int32_t v = 0; v < model.n_output && node.modal == nullptr; ++v) {
    const Matrix map = diagonal(weight[v]);
    if (weight[v] != 0) add_local(model, node, 1, &v, &map, scratch, local);
  }
  if (node.modal) {
    ModeSum sum(model, *node.modal, scratch);
    sum.add_all(weight, shared, local);
    for (std::int32_t m = 0; m < node.n_prescribed && own != 0; ++m)
      add_shared(model, node.prescribed[m], -own * node.prescribed_weight[m], scratch);
    sum.finish(local);
  }
  if (own != 0) add_round_tool(node, own, weight);
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

double curvature(const phn_model& model, const ActiveNode& node, const Matrix& stiffness) {
  double apart = 0, all = 0;
  for (int k = 0; k < 6; ++k) {
    const Vector d = unit_vector(k / 2, (k % 2 - 0.5) * 2 * model.max_displacement_m), linear = stiffness * d;
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
  stiffen(stiffness);
  return stiffness;
}

}  // namespace PHN_RUNTIME
