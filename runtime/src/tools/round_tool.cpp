#include "tools/round_tool.hpp"

#include "core/evaluate.hpp"
#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

/// Tolerance of the sum of barycentric weights. A point whose movable weight is smaller counts as fixed.
constexpr double weight_tolerance = 1e-6;

/// Weights up to this are rounding errors, for example of phn_nearest at the corner opposite to an edge, where no tool
/// need exist.
constexpr double negligible_weight = 1e-12;

/// Adds to the weight of an active node. A new node becomes the last of n.
[[gnu::noinline]] void add(std::int32_t node, double weight, std::int32_t& n, std::int32_t* active, double* weights) {
  std::int32_t i = 0;
  while (i < n && active[i] != node) ++i;
  if (i == n) {
    active[n++] = node;
    weights[i] = 0;
  }
  weights[i] += weight;
}

/// Corners of triangle t of the two lists, one behind the other.
const std::int32_t* probe_triangle(const phn_model& model, std::int32_t t) {
  const std::int32_t n = model.n_probe_triangles;
  return (t < n ? model.probe_triangles : model.outer_triangles) + 3 * static_cast<std::size_t>(t < n ? t : t - n);
}

}  // namespace

std::int32_t find_corners(const phn_model& model, std::int32_t node, Corner corner[3]) {
  corner[0] = {find_active(model, node), 1};
  if (corner[0].active >= 0) return 1;
  const std::int32_t vertex = find_vertex(model, node);
  std::int32_t row = 0, n = 0;
  for (std::int32_t end = model.n_covered; row < end;) {
    const std::int32_t middle = row + (end - row) / 2;
    if (model.covered[4 * static_cast<std::size_t>(middle)] < vertex)
      row = middle + 1;
    else
      end = middle;
  }
  const std::int32_t* covered = model.covered + 4 * static_cast<std::size_t>(row);
  if (row == model.n_covered || covered[0] != vertex) return 0;
  const double first = covered[2], second = covered[3], whole = schema::whole_weight;
  const double weight[3] = {first / whole, (whole - first) / whole * (second / whole),
                            (whole - first) / whole * ((whole - second) / whole)};
  for (int k = 0; k < 3; ++k)
    if (weight[k] > 0) corner[n++] = {probe_triangle(model, covered[1])[k], weight[k]};
  return n;
}

int find_place(const phn_model& model, const phn_tool& tool, Place& place) {
  if (!is_of_this_version(tool)) return PHN_ERROR_VERSION;
  if (!finite(tool.displacement)) return PHN_ERROR_NOT_FINITE;
  place.n_nodes = 0;
  place.point = {};
  double sum = 0, movable = 0;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= 0 && w <= 1 + weight_tolerance)) return PHN_ERROR_ARGUMENT;
    sum += w;
    if (w == 0) continue;
    Corner corner[3];
    const std::int32_t n = find_corners(model, tool.nodes[k], corner), vertex = find_vertex(model, tool.nodes[k]);
    if (n == 0) {
      if (w > negligible_weight && vertex < model.n_output) return PHN_ERROR_NOT_ACTIVE;
      continue;  // fixed
    }
    movable += w;
    place.point += w * vector_at(vertex >= 0 ? vertex_point(model, vertex) : model.active[corner[0].active].point);
    for (std::int32_t i = 0; i < n; ++i)
      add(corner[i].active, w * corner[i].weight, place.n_nodes, place.active, place.weight);
  }
  if (!(sum >= 1 - weight_tolerance && sum <= 1 + weight_tolerance)) return PHN_ERROR_ARGUMENT;
  if (!(movable > weight_tolerance)) return PHN_ERROR_NOT_ACTIVE;
  place.point /= movable;
  place.fixed_weight = sum - movable;
  place.least_weight = least_share * movable;
  return PHN_OK;
}

bool is_round(const phn_model& model, const Place& place) {
  for (std::int32_t i = 0; i < place.n_nodes; ++i)
    if (!model.active[place.active[i]].moves_mean) return false;
  return true;
}

bool is_beside_fixed(const phn_model& model, const Place& place) {
  return place.fixed_weight > least_share && is_round(model, place);
}

bool has_round_tools(const phn_model& model) {
  std::int32_t i = 0;
  while (i < model.n_active && !model.active[i].moves_mean) ++i;
  return i < model.n_active;
}

const schema::Neighbours* find_neighbours(Arena& arena, const phn_model& model) {
  if (!has_round_tools(model)) return nullptr;
  const std::int32_t n_points = model.n_active + model.n_linear;
  const bool spread = model.n_probe_triangles > 0;
  const std::int32_t n_inner = spread ? model.n_probe_triangles : model.n_triangles;
  auto* first = arena.take<schema::NearPoints>(static_cast<std::size_t>(n_points));
  auto* neighbours = arena.take<schema::Neighbours>(static_cast<std::size_t>(n_points));
  if (first == nullptr || neighbours == nullptr) return nullptr;
  const auto corner_of = [&](std::int32_t t, int k) {
    const std::size_t at = 3 * static_cast<std::size_t>(t < n_inner ? t : t - n_inner) + static_cast<std::size_t>(k);
    if (t >= n_inner) return model.outer_triangles[at] < model.n_active ? -1 : model.outer_triangles[at];
    return spread ? model.probe_triangles[at] : find_active(model, vertex_node(model, model.triangles[at]));
  };
  const auto point_of = [&](std::int32_t i) { return model.active[i].point; };
  schema::find_neighbours(n_points, point_of, n_inner + model.n_outer_triangles, corner_of, first, neighbours);
  return neighbours;
}

double transmission_of(const phn_model& model, const Place& place) {
  return model.active[place.active[0]].moves_mean ? 1 : place.weight[0];
}

/// The weights of equation (x).
Mean mean_at(const phn_model& model, const schema::Neighbours* neighbours, const Place& place) {
  Mean mean;
  mean.n = place.n_nodes;
  mean.transmission = transmission_of(model, place);
  double sum = 0;
  for (std::int32_t k = 0; k < place.n_nodes; ++k) sum += place.weight[k];
  Vector middle = {};
  for (std::int32_t k = 0; k < place.n_nodes; ++k) {
    mean.active[k] = place.active[k];
    mean.share[k] = mean.weight[k] = place.weight[k] / sum;
    middle += mean.weight[k] * vector_at(model.active[place.active[k]].point);
  }
  if (place.n_nodes == 1 || neighbours == nullptr) return mean;
  Vector aside = place.point - middle;
  double squares = 0;
  for (std::int32_t k = 0; k < place.n_nodes; ++k) {
    const Vector from = place.point - vector_at(model.active[place.active[k]].point);
    squares += mean.share[k] * dot(from, from);
  }
  const double square = dot(aside, aside);
  aside *= squares > 0 ? (squares - square) / (squares + square) : 0;
  for (std::int32_t k = 0; k < place.n_nodes; ++k) {
    const schema::Neighbours& near = neighbours[place.active[k]];
    const Vector away = middle - vector_at(model.active[place.active[k]].point),
                 along = mean.share[k] * (0.5 * away + aside);
    for (std::int32_t i = 0; i < near.n; ++i) {
      const double part = dot(along.x, near.slope[i]);
      add(near.point[i], part, mean.n, mean.active, mean.weight);
      mean.weight[k] -= part;
    }
  }
  return mean;
}

void respond_as_mean(const phn_model& model, const Mean& mean, const Vector& d, Vector& force, double* energy,
                     Matrix* stiffness) {
  const Vector at = d / mean.transmission;
  // -0 + x has the sign of x also if x is zero: one node keeps its bits.
  force = {{-0.0, -0.0, -0.0}};
  if (energy) *energy = -0.0;
  if (stiffness) *stiffness = {};
  for (std::int32_t i = 0; i < mean.n; ++i) {
    Vector f;
    double e = 0;
    Matrix k = {};
    evaluate_force(model, model.active[mean.active[i]], at.x, f.x, energy ? &e : nullptr, stiffness ? k.a : nullptr);
    force += mean.weight[i] * f / mean.transmission;
    if (energy) *energy += mean.weight[i] * e;
    if (stiffness) *stiffness += mean.weight[i] / (mean.transmission * mean.transmission) * k;
  }
  // Sums of the largest numbers that a model may hold overflow.
  if (!is_finite(force)) force = {};
  if (energy && !std::isfinite(*energy)) *energy = 0;
  if (stiffness && !all_finite(stiffness->a, 9)) *stiffness = {};
}

}  // namespace PHN_RUNTIME
