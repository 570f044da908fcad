#include "tools/round_tool.hpp"

#include "core/evaluate.hpp"
#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

/// Tolerance of the sum of barycentric weights; a point whose movable part is smaller counts as fixed.
constexpr double weight_slack = 1e-6;

/// Added to the squares of the edges at a node, as a fraction of their sum: a gradient across the surface, in which
/// direction there are hardly any differences, is small. Values from 0.003 to 0.03 give the same errors.
constexpr double across = 0.03;

void add(std::int32_t active, double weight, Mean& mean) {
  std::int32_t i = 0;
  while (i < mean.n && mean.active[i] != active) ++i;
  if (i == mean.n) {
    mean.active[mean.n++] = active;
    mean.weight[i] = 0;
  }
  mean.weight[i] += weight;
}

}  // namespace

int find_place(const phn_model& model, const phn_tool& tool, Place& place) {
  place.n_nodes = 0;
  double sum = 0, movable = 0;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= 0 && w <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
    sum += w;
    if (w == 0) continue;
    const std::int32_t active = find_active(model, tool.nodes[k]);
    if (active < 0 && find_vertex(model, tool.nodes[k]) < model.n_output) return PHN_ERROR_NOT_ACTIVE;
    if (active < 0) continue;  // fixed
    movable += w;
    std::int32_t i = 0;
    while (i < place.n_nodes && place.active[i] != active) ++i;
    if (i == place.n_nodes) place.weight[place.n_nodes++] = 0;
    place.active[i] = active;
    place.weight[i] += w;
  }
  if (!(sum >= 1 - weight_slack && sum <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
  if (!(movable > weight_slack)) return PHN_ERROR_NOT_ACTIVE;
  return finite(tool.displacement) ? PHN_OK : PHN_ERROR_NOT_FINITE;
}

bool is_round(const phn_model& model, const Place& place) {
  for (std::int32_t i = 0; i < place.n_nodes; ++i) {
    if (!model.active[place.active[i]].moves_mean) return false;
  }
  return true;
}

Neighbours find_neighbours(Arena& arena, const phn_model& model) {
  bool round = false;
  for (std::int32_t i = 0; i < model.n_active && model.active; ++i) round = round || model.active[i].moves_mean;
  if (!round) return {};
  auto* begin = arena.take<std::int32_t>(static_cast<std::size_t>(model.n_active) + 1);
  auto* active = arena.take<std::int32_t>(6, static_cast<std::size_t>(model.n_triangles));
  if (begin == nullptr || active == nullptr) return {};
  const auto each = [&](auto take) {
    for (std::int32_t t = 0; t < model.n_triangles; ++t) {
      std::int32_t at[3];
      for (int k = 0; k < 3; ++k)
        at[k] = find_active(model, vertex_node(model, model.triangles[3 * static_cast<std::size_t>(t) + k]));
      for (int k = 0; k < 3; ++k) {
        for (int l = 1; l < 3 && at[k] >= 0; ++l) {
          if (at[(k + l) % 3] >= 0) take(at[k], at[(k + l) % 3]);
        }
      }
    }
  };
  for (std::int32_t i = 0; i <= model.n_active; ++i) begin[i] = 0;
  each([&](std::int32_t i, std::int32_t) { ++begin[i]; });
  for (std::int32_t i = 0; i < model.n_active; ++i) begin[i + 1] += begin[i];
  each([&](std::int32_t i, std::int32_t j) { active[--begin[i]] = j; });
  return {begin, active};
}

/// sum_k w_k [E_k + g_k . (x - x_k) / 2], exact for quadratic functions of the place x. The gradient g_k is that of the
/// least squares of the differences to the neighbours.
Mean mean_at(const phn_model& model, const Neighbours& neighbours, const Place& place) {
  Mean mean;
  mean.n = place.n_nodes;
  const bool round = is_round(model, place);
  mean.lever = round ? 1 : place.weight[0];
  double sum = 0;
  for (std::int32_t k = 0; k < place.n_nodes; ++k) sum += place.weight[k];
  Vector x = {};
  for (std::int32_t k = 0; k < place.n_nodes; ++k) {
    mean.active[k] = place.active[k];
    mean.weight[k] = place.weight[k] / sum;
    x += mean.weight[k] * vector_at(model.active[place.active[k]].point);
  }
  if (place.n_nodes == 1 || neighbours.begin == nullptr) return mean;
  for (std::int32_t k = 0; k < place.n_nodes; ++k) {
    const std::int32_t own = place.active[k], begin = neighbours.begin[own], n = neighbours.begin[own + 1] - begin;
    if (n > most_neighbours) continue;
    const Vector middle = vector_at(model.active[own].point);
    const auto edge = [&](std::int32_t i) {
      return vector_at(model.active[neighbours.active[begin + i]].point) - middle;
    };
    Matrix moment = {};
    for (std::int32_t i = 0; i < n; ++i) moment += outer(edge(i), edge(i));
    moment += diagonal(across * (moment(0, 0) + moment(1, 1) + moment(2, 2)));
    const Vector half = place.weight[k] / sum / 2 * (inverse_of(moment) * (x - middle));
    for (std::int32_t i = 0; i < n; ++i) {
      const double part = dot(half, edge(i));
      if (!std::isfinite(part)) continue;  // squares of coordinates overflow
      add(neighbours.active[begin + i], part, mean);
      mean.weight[k] -= part;
    }
  }
  return mean;
}

void respond_alone(const phn_model& model, const Mean& mean, const Vector& d, Vector& force, double* energy,
                   Matrix* stiffness) {
  const Vector at = d / mean.lever;
  for (std::int32_t i = 0; i < mean.n; ++i) {
    Vector f;
    double e = 0;
    Matrix k = {};
    evaluate_derivatives(model, model.active[mean.active[i]], at.x, f.x, energy ? &e : nullptr,
                         stiffness ? k.a : nullptr);
    // The first term is no sum, so that one node keeps the sign of its zeros.
    f = mean.weight[i] * f / mean.lever;
    force = i == 0 ? f : force + f;
    if (energy) *energy = i == 0 ? mean.weight[i] * e : *energy + mean.weight[i] * e;
    if (stiffness) *stiffness = (i == 0 ? Matrix{} : *stiffness) + mean.weight[i] / (mean.lever * mean.lever) * k;
  }
  // Sums of the largest numbers that a model may hold overflow.
  if (!is_finite(force)) force = {};
  if (energy && !std::isfinite(*energy)) *energy = 0;
  if (stiffness && !all_finite(stiffness->a, 9)) *stiffness = {};
}

}  // namespace PHN_RUNTIME
