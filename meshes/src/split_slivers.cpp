#include "split_slivers.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <phynness/meshes/meshes.hpp>
#include <set>

#include "radius_ratio.hpp"
#include "topology.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;
constexpr int cell_edges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

Vector node_at(const RawMesh& raw, std::int32_t node) {
  return Eigen::Map<const Vector>(raw.nodes[static_cast<std::size_t>(node)].data());
}

/// Radius ratio with the sign of the volume.
double signed_shape(const std::array<Vector, 4>& x) {
  const Vector u = x[1] - x[0], v = x[2] - x[0], w = x[3] - x[0];
  const double shape = radius_ratio(u, v, w);
  return u.dot(v.cross(w)) < 0 ? -shape : shape;
}

double signed_shape(const RawMesh& raw, const Tetrahedron& cell) {
  return signed_shape({node_at(raw, cell[0]), node_at(raw, cell[1]), node_at(raw, cell[2]), node_at(raw, cell[3])});
}

Edge edge_of(const Tetrahedron& cell, const int (&ends)[2]) {
  return {std::min(cell[ends[0]], cell[ends[1]]), std::max(cell[ends[0]], cell[ends[1]])};
}

/// Edges of faces that belong to one cell only.
std::set<Edge> surface_edges(const RawMesh& raw) {
  std::set<Triangle> faces;
  for (const Tetrahedron& cell : raw.tetrahedra)
    for (int k = 0; k < 4; ++k) {
      Triangle face{cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]};
      std::sort(face.begin(), face.end());
      if (const auto [found, is_new] = faces.insert(face); !is_new) faces.erase(found);
    }
  std::set<Edge> edges;
  for (const Triangle& t : faces)
    for (const Edge& e : {Edge{t[0], t[1]}, Edge{t[1], t[2]}, Edge{t[0], t[2]}}) edges.insert(e);
  return edges;
}

/// An edge with all cells around it, and the best position of a node in it.
struct Split {
  Edge edge{};
  std::vector<std::size_t> ring;
  Vector x = Vector::Zero();
  double shape = -1;
};

/// The worst shape of the cells around a node in the edge.
double worst_shape(const RawMesh& raw, const Split& split, const Vector& x) {
  double worst = 1;
  for (const std::size_t c : split.ring) {
    const Tetrahedron& cell = raw.tetrahedra[c];
    const double sign = signed_shape(raw, cell) < 0 ? -1 : 1;
    for (const std::int32_t end : split.edge) {
      std::array<Vector, 4> corners;
      for (int k = 0; k < 4; ++k) corners[k] = cell[k] == end ? x : node_at(raw, cell[k]);
      worst = std::min(worst, sign * signed_shape(corners));
    }
  }
  return worst;
}

/// Searches the best position from the midpoint of the edge, with decreasing steps.
void place(const RawMesh& raw, Split& split) {
  const Vector a = node_at(raw, split.edge[0]), b = node_at(raw, split.edge[1]);
  split.x = (a + b) / 2;
  split.shape = worst_shape(raw, split, split.x);
  constexpr int most_tries = 200;
  double step = (b - a).norm() / 4;
  for (int tries = 0; tries < most_tries && step > 0.005 * (b - a).norm(); ++tries) {
    const Vector from = split.x;
    for (int d = 0; d < 27; ++d) {
      const Vector x = from + step * Eigen::RowVector3i(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1).cast<double>();
      if (const double shape = worst_shape(raw, split, x); shape > split.shape) split.shape = shape, split.x = x;
    }
    if (split.x == from) step /= 2;
  }
}

/// The inner edges of all flat cells, with the cells around them.
std::map<Edge, Split> splits_of(const RawMesh& raw, const std::vector<std::size_t>& flat) {
  const std::set<Edge> surface = surface_edges(raw);
  std::map<Edge, Split> splits;
  for (const std::size_t c : flat)
    for (const auto& ends : cell_edges)
      if (const Edge edge = edge_of(raw.tetrahedra[c], ends); !surface.contains(edge)) splits[edge].edge = edge;
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
    for (const auto& ends : cell_edges)
      if (const auto found = splits.find(edge_of(raw.tetrahedra[c], ends)); found != splits.end())
        found->second.ring.push_back(c);
  return splits;
}

void apply(RawMesh& raw, const Split& split) {
  const auto node = static_cast<std::int32_t>(raw.nodes.size());
  raw.nodes.push_back({split.x(0), split.x(1), split.x(2)});
  for (const std::size_t c : split.ring) {
    Tetrahedron copy = raw.tetrahedra[c];
    std::replace(copy.begin(), copy.end(), split.edge[0], node);
    std::replace(raw.tetrahedra[c].begin(), raw.tetrahedra[c].end(), split.edge[1], node);
    raw.tetrahedra.push_back(copy);
  }
}

}  // namespace

std::int32_t split_slivers(RawMesh& raw) {
  constexpr int most_rounds = 4;
  std::int32_t added = 0;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<std::size_t> flat;
    for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
      if (std::abs(signed_shape(raw, raw.tetrahedra[c])) < sliver_quality) flat.push_back(c);
    if (flat.empty()) break;
    auto splits = splits_of(raw, flat);
    std::set<std::size_t> changed;
    const std::int32_t before = added;
    for (const std::size_t c : flat) {
      const Split* best = nullptr;
      for (const auto& ends : cell_edges) {
        const auto found = splits.find(edge_of(raw.tetrahedra[c], ends));
        if (found == splits.end()) continue;
        Split& split = found->second;
        if (std::any_of(split.ring.begin(), split.ring.end(), [&](std::size_t r) { return changed.contains(r); }))
          continue;
        if (split.shape < 0) place(raw, split);
        if (split.shape >= sliver_quality && (!best || split.shape > best->shape)) best = &split;
      }
      if (!best) continue;
      changed.insert(best->ring.begin(), best->ring.end());
      apply(raw, *best);
      ++added;
    }
    if (added == before) break;
  }
  return added;
}

}  // namespace phynness::meshes
