#include "flat_cells.hpp"

#include <algorithm>
#include <map>
#include <phynness/meshes/meshes.hpp>
#include <set>

#include "surface/geometry.hpp"
#include "surface/topology.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;
constexpr int most_rounds = 4;

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

std::vector<std::size_t> flat_cells(const RawMesh& raw) {
  std::vector<std::size_t> flat;
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
    if (std::abs(signed_shape(raw, raw.tetrahedra[c])) < sliver_quality) flat.push_back(c);
  return flat;
}

Triangle face_of(const Tetrahedron& cell, int opposite) {
  Triangle face{cell[(opposite + 1) % 4], cell[(opposite + 2) % 4], cell[(opposite + 3) % 4]};
  std::sort(face.begin(), face.end());
  return face;
}

std::array<Edge, 6> edges_of(const Tetrahedron& c) {
  return {edge_of(c[0], c[1]), edge_of(c[0], c[2]), edge_of(c[0], c[3]),
          edge_of(c[1], c[2]), edge_of(c[1], c[3]), edge_of(c[2], c[3])};
}

/// Faces that belong to one cell only, as sorted nodes, and their edges.
struct Boundary {
  std::set<Triangle> faces;
  std::set<Edge> edges;

  explicit Boundary(const RawMesh& raw) {
    for (const Tetrahedron& cell : raw.tetrahedra)
      for (int k = 0; k < 4; ++k)
        if (const auto [found, is_new] = faces.insert(face_of(cell, k)); !is_new) faces.erase(found);
    for (const Triangle& t : faces) edges.insert({{t[0], t[1]}, {t[1], t[2]}, {t[0], t[2]}});
  }
};

double face_quality(const RawMesh& raw, const Tetrahedron& cell, int opposite) {
  const auto x = [&](int k) { return node_at(raw, cell[(opposite + k) % 4]); };
  return radius_ratio(x(2) - x(1), x(3) - x(1));
}

/// Whether the faces that come to light without the cell are sound, or better than those that go.
/// @param inner  nodes opposite to the faces that go
bool faces_improve(const RawMesh& raw, const Tetrahedron& cell, const std::vector<std::int32_t>& inner) {
  double before = 1, after = 1;
  for (int k = 0; k < 4; ++k) {
    const bool goes = std::find(inner.begin(), inner.end(), cell[k]) != inner.end();
    double& worst = goes ? before : after;
    worst = std::min(worst, face_quality(raw, cell, k));
  }
  return after > std::min(before, sliver_quality);
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
  const std::set<Edge> surface = Boundary(raw).edges;
  std::map<Edge, Split> splits;
  for (const std::size_t c : flat)
    for (const Edge& edge : edges_of(raw.tetrahedra[c]))
      if (!surface.contains(edge)) splits[edge].edge = edge;
  for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
    for (const Edge& edge : edges_of(raw.tetrahedra[c]))
      if (const auto found = splits.find(edge); found != splits.end()) found->second.ring.push_back(c);
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

std::int32_t peel_slivers(RawMesh& raw) {
  std::int32_t removed = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const auto flat = flat_cells(raw);
    if (flat.empty()) break;
    const Boundary boundary(raw);
    std::set<std::size_t> gone;
    // One swap per neighbourhood and round, so that each is checked on the present surface.
    std::set<std::int32_t> touched;
    for (const std::size_t c : flat) {
      const Tetrahedron& cell = raw.tetrahedra[c];
      std::vector<std::int32_t> inner;  // nodes opposite to the faces on the surface: ends of the new edge
      for (int k = 0; k < 4; ++k)
        if (boundary.faces.contains(face_of(cell, k))) inner.push_back(cell[k]);
      const bool fresh = std::none_of(cell.begin(), cell.end(), [&](std::int32_t n) { return touched.count(n) > 0; });
      const bool tip = inner.size() == 3;  // the node of three faces goes with the cell
      if (!fresh || !(tip || inner.size() == 2) || !faces_improve(raw, cell, inner)) continue;
      if (!tip && boundary.edges.contains(edge_of(inner[0], inner[1]))) continue;
      touched.insert(cell.begin(), cell.end());
      gone.insert(c);
    }
    if (gone.empty()) break;
    std::size_t at = 0;
    std::erase_if(raw.tetrahedra, [&](const Tetrahedron&) { return gone.contains(at++); });
    removed += static_cast<std::int32_t>(gone.size());
  }
  return removed;
}

std::int32_t split_slivers(RawMesh& raw) {
  std::int32_t added = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const auto flat = flat_cells(raw);
    if (flat.empty()) break;
    auto splits = splits_of(raw, flat);
    std::set<std::size_t> changed;
    const std::int32_t before = added;
    for (const std::size_t c : flat) {
      const Split* best = nullptr;
      for (const Edge& edge : edges_of(raw.tetrahedra[c])) {
        const auto found = splits.find(edge);
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
