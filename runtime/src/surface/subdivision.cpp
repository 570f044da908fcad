#include "surface/subdivision.hpp"

#include <cstring>

namespace PHN_RUNTIME {
namespace {

constexpr std::int32_t none = -1, more_than_two = -2;

/// Rows of four floats, which compilers keep in one register.
struct Row {
  float value[4];
};

Row load(const float* rows, std::int32_t i) {
  Row row;
  std::memcpy(&row, rows + 4 * static_cast<std::size_t>(i), sizeof row);
  return row;
}

/// cos t for 0 <= t <= pi by its series, so that results do not depend on the platform's library. Omitted terms are
/// below 1e-16.
double cosine(double t) {
  double term = 1, sum = 1;
  for (int k = 1; k <= 15; ++k) {
    term *= -t * t / ((2 * k - 1) * (2 * k));
    sum += term;
  }
  return sum;
}

/// Weight of each of n neighbours: C. Loop, Smooth subdivision surfaces based on triangles (1987).
double loop_share(std::int32_t n) {
  constexpr double turn = 6.283185307179586;
  const double c = 0.375 + 0.25 * cosine(turn / n);
  return (0.625 - c * c) / n;
}

/// Finds edges by their ends. Edges that begin at one vertex form a linked list.
struct EdgeTable {
  SurfaceEdge* edges;
  std::int32_t *head, *next;
  std::int32_t n;

  std::int32_t add(std::int32_t a, std::int32_t b, std::int32_t opposite) {
    const std::int32_t low = a < b ? a : b, high = a < b ? b : a;
    for (std::int32_t e = head[low]; e != none; e = next[e]) {
      if (edges[e].end[1] != high) continue;
      edges[e].opposite[1] = edges[e].opposite[1] == none ? opposite : more_than_two;
      return e;
    }
    edges[n] = {{low, high}, {opposite, none}};
    next[n] = head[low];
    return head[low] = n++;
  }
};

bool is_crease(const SurfaceEdge& edge) { return edge.opposite[0] == edge.end[0]; }

/// Sets rules and neighbours from the edges: Loop's rule for a vertex with no crease or at the end of one, the weights
/// 3/4, 1/8, 1/8 of a cubic spline along a crease, and no motion where more than two creases meet.
void vertex_rules(SurfaceLevel& level, VertexRule* rules, std::int32_t* neighbors, std::int32_t* valence,
                  std::int32_t* creases) {
  const std::int32_t n = level.n_vertices;
  for (std::int32_t v = 0; v < n; ++v) valence[v] = creases[v] = 0;
  for (std::int32_t e = 0; e < level.n_edges; ++e)
    for (const std::int32_t v : level.edges[e].end) {
      ++valence[v];
      creases[v] += is_crease(level.edges[e]);
    }
  std::int32_t first = 0;
  for (std::int32_t v = 0; v < n; ++v) {
    const bool smooth = valence[v] > 0 && creases[v] <= 1, along = creases[v] == 2;
    const std::int32_t count = smooth ? valence[v] : along ? 2 : 0;
    const double share = smooth ? loop_share(count) : along ? 0.125 : 0;
    rules[v] = {first, static_cast<float>(1 - count * share), static_cast<float>(share)};
    valence[v] = first;  // from here on the position for the next neighbour
    first += count;
  }
  rules[n] = {first, 0, 0};
  for (std::int32_t e = 0; e < level.n_edges; ++e) {
    const SurfaceEdge& edge = level.edges[e];
    for (int k = 0; k < 2; ++k) {
      const std::int32_t v = edge.end[k];
      if (creases[v] <= 1 || (creases[v] == 2 && is_crease(edge))) neighbors[valence[v]++] = edge.end[1 - k];
    }
  }
}

}  // namespace

int count_surface(const phn_model& model, std::int32_t levels, SurfaceCounts* counts) {
  if (model.n_triangles == 0) return PHN_ERROR_UNDEFINED;
  for (std::int32_t t = 0; t < model.n_triangles; ++t) {
    const std::int32_t* v = model.triangles + 3 * static_cast<std::size_t>(t);
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) return PHN_ERROR_GEOMETRY;
  }
  const std::int64_t n = static_cast<std::int64_t>(model.n_output) + model.n_fixed, t = model.n_triangles;
  counts[0] = {n, 3 * t, t};
  for (std::int32_t k = 0; k < levels; ++k) {
    const SurfaceCounts& c = counts[k];
    counts[k + 1] = {c.vertices + c.edges, 2 * c.edges + 3 * c.triangles, 4 * c.triangles};
  }
  // Indices of components must also fit into 32 bits.
  const std::int64_t largest = INT32_MAX / 4;
  const SurfaceCounts& last = counts[levels];
  return last.vertices > largest || last.edges > largest || last.triangles > largest ? PHN_ERROR_TOO_LARGE : PHN_OK;
}

SurfaceLevel subdivide(std::int32_t n_vertices, std::int32_t n_triangles, std::int32_t* triangles, SurfaceEdge* edges,
                       VertexRule* rules, std::int32_t* neighbors, std::int32_t* scratch) {
  const auto n_corners = 3 * static_cast<std::size_t>(n_triangles);
  // The parents are at the end of the memory; the children, written from its start, never overwrite an unread parent.
  const std::int32_t* parent = triangles + 3 * n_corners;
  std::memmove(triangles + 3 * n_corners, triangles, n_corners * sizeof *triangles);
  EdgeTable table = {edges, scratch, scratch + 2 * static_cast<std::size_t>(n_vertices), 0};
  for (std::int32_t v = 0; v < n_vertices; ++v) table.head[v] = none;
  for (std::int32_t t = 0; t < n_triangles; ++t, parent += 3, triangles += 12) {
    const std::int32_t a = parent[0], b = parent[1], c = parent[2];
    const std::int32_t ab = n_vertices + table.add(a, b, c), bc = n_vertices + table.add(b, c, a),
                       ca = n_vertices + table.add(c, a, b);
    const std::int32_t children[12] = {a, ab, ca, b, bc, ab, c, ca, bc, ab, bc, ca};
    std::memcpy(triangles, children, sizeof children);
  }
  for (std::int32_t e = 0; e < table.n; ++e) {
    if (edges[e].opposite[1] >= 0) continue;
    edges[e].opposite[0] = edges[e].end[0];
    edges[e].opposite[1] = edges[e].end[1];
  }
  SurfaceLevel level = {n_vertices, table.n, edges, rules, neighbors};
  vertex_rules(level, rules, neighbors, scratch, scratch + n_vertices);
  return level;
}

void refine(const SurfaceLevel& level, const float* coarse, float* fine, int stride) {
  // Rows of three are written as four numbers; the next row overwrites the fourth.
  for (std::int32_t v = 0; v < level.n_vertices; ++v, fine += stride) {
    const VertexRule &rule = level.rules[v], &next = level.rules[v + 1];
    Row sum = {};
    for (std::int32_t i = rule.first; i < next.first; ++i) {
      const Row row = load(coarse, level.neighbors[i]);
      for (int k = 0; k < 4; ++k) sum.value[k] += row.value[k];
    }
    const Row own = load(coarse, v);
    for (int k = 0; k < 4; ++k) sum.value[k] = rule.self * own.value[k] + rule.share * sum.value[k];
    std::memcpy(fine, &sum, sizeof sum);
  }
  for (std::int32_t e = 0; e < level.n_edges; ++e, fine += stride) {
    const SurfaceEdge& edge = level.edges[e];
    const Row a = load(coarse, edge.end[0]), b = load(coarse, edge.end[1]), c = load(coarse, edge.opposite[0]),
              d = load(coarse, edge.opposite[1]);
    Row sum;
    for (int k = 0; k < 4; ++k) sum.value[k] = 0.375f * (a.value[k] + b.value[k]) + 0.125f * (c.value[k] + d.value[k]);
    if (e + 1 < level.n_edges) {
      std::memcpy(fine, &sum, sizeof sum);
    } else {
      for (int k = 0; k < stride; ++k) fine[k] = sum.value[k];
    }
  }
}

}  // namespace PHN_RUNTIME
