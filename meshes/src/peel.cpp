#include "peel.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <phynness/meshes/meshes.hpp>
#include <set>

#include "radius_ratio.hpp"
#include "topology.hpp"

namespace phynness::meshes {
namespace {

double quality(const RawMesh& raw, const Tetrahedron& cell) {
  const auto x = [&](int k) { return Eigen::Map<const Eigen::RowVector3d>(raw.nodes[cell[k]].data()); };
  return radius_ratio(x(1) - x(0), x(2) - x(0), x(3) - x(0));
}

/// Faces that belong to one cell only, as sorted nodes.
std::set<Triangle> boundary_faces(const RawMesh& raw) {
  std::set<Triangle> faces;
  for (const Tetrahedron& cell : raw.tetrahedra)
    for (int k = 0; k < 4; ++k) {
      Triangle face{cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]};
      std::sort(face.begin(), face.end());
      if (const auto [found, is_new] = faces.insert(face); !is_new) faces.erase(found);
    }
  return faces;
}

double face_quality(const RawMesh& raw, const Tetrahedron& cell, int opposite) {
  const auto x = [&](int k) {
    return Eigen::Map<const Eigen::RowVector3d>(raw.nodes[cell[(opposite + k) % 4]].data());
  };
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

}  // namespace

std::int32_t peel_slivers(RawMesh& raw) {
  constexpr int most_rounds = 4;
  std::int32_t removed = 0;
  for (int round = 0; round < most_rounds; ++round) {
    std::vector<std::size_t> flat;
    for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
      if (quality(raw, raw.tetrahedra[c]) < sliver_quality) flat.push_back(c);
    if (flat.empty()) break;
    const std::set<Triangle> boundary = boundary_faces(raw);
    std::set<Edge> surface_edges;
    for (const Triangle& t : boundary)
      for (const Edge& e : {Edge{t[0], t[1]}, Edge{t[1], t[2]}, Edge{t[0], t[2]}}) surface_edges.insert(e);
    std::set<std::size_t> gone;
    // One swap per neighbourhood and round, so that each is checked on the present surface.
    std::set<std::int32_t> touched;
    for (const std::size_t c : flat) {
      const Tetrahedron& cell = raw.tetrahedra[c];
      std::vector<std::int32_t> inner;  // nodes opposite to the faces on the surface: ends of the new edge
      for (int k = 0; k < 4; ++k) {
        Triangle face{cell[(k + 1) % 4], cell[(k + 2) % 4], cell[(k + 3) % 4]};
        std::sort(face.begin(), face.end());
        if (boundary.count(face)) inner.push_back(cell[k]);
      }
      const bool fresh = std::none_of(cell.begin(), cell.end(), [&](std::int32_t n) { return touched.count(n) > 0; });
      const bool tip = inner.size() == 3;  // the node of three faces goes with the cell
      if (!fresh || !(tip || inner.size() == 2) || !faces_improve(raw, cell, inner)) continue;
      if (!tip && surface_edges.count({std::min(inner[0], inner[1]), std::max(inner[0], inner[1])})) continue;
      touched.insert(cell.begin(), cell.end());
      gone.insert(c);
    }
    if (gone.empty()) break;
    std::vector<Tetrahedron> kept;
    for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c)
      if (!gone.count(c)) kept.push_back(raw.tetrahedra[c]);
    raw.tetrahedra = std::move(kept);
    removed += static_cast<std::int32_t>(gone.size());
  }
  return removed;
}

}  // namespace phynness::meshes
