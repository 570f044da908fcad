#include "mirror.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <set>

#include "file_mesh.hpp"
#include "geometry.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;

/// The node nearest to x, or -1 if no node lies within the tolerance.
/// @param by_x  the nodes in ascending order of their first coordinate
std::int32_t nearest(const Points& nodes, const std::vector<std::int32_t>& by_x, const Vector& x, double tolerance) {
  const auto before = [&nodes](std::int32_t node, double value) { return nodes(node, 0) < value; };
  std::int32_t best = -1;
  double distance = tolerance;
  for (auto i = std::lower_bound(by_x.begin(), by_x.end(), x[0] - tolerance, before);
       i != by_x.end() && nodes(*i, 0) <= x[0] + tolerance; ++i)
    if (const double d = (nodes.row(*i) - x).norm(); d <= distance) distance = d, best = *i;
  return best;
}

std::vector<std::int32_t> pair_nodes(const Mesh& mesh, const SymmetryPlane& plane, double tolerance) {
  const Vector low = mesh.nodes.colwise().minCoeff(), high = mesh.nodes.colwise().maxCoeff();
  const Vector n(plane.normal[0], plane.normal[1], plane.normal[2]);
  Vector point(plane.point[0], plane.point[1], plane.point[2]);
  if (plane.fraction) point = low + point.cwiseProduct(high - low);
  const auto reflected = [&](std::int32_t i) -> Vector {
    const Vector x = mesh.nodes.row(i);
    return x - 2 * (x - point).dot(n) * n;
  };

  std::vector<std::int32_t> by_x(static_cast<std::size_t>(mesh.n_nodes()));
  std::iota(by_x.begin(), by_x.end(), 0);
  std::sort(by_x.begin(), by_x.end(),
            [&](std::int32_t p, std::int32_t q) { return mesh.nodes(p, 0) < mesh.nodes(q, 0); });
  std::vector<std::int32_t> image(static_cast<std::size_t>(mesh.n_nodes())), alone;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) {
    image[i] = nearest(mesh.nodes, by_x, reflected(i), tolerance);
    if (image[i] < 0) alone.push_back(i);
  }
  if (!alone.empty()) {
    const double off = (mesh.nodes.rowwise() - reflected(alone.front())).rowwise().norm().minCoeff();
    throw input_error(plane.where.prefix() + "the mesh is not symmetric",
                      counted(alone.size(), "node has", "nodes have") + " no mirror image within " +
                          length_text(tolerance) + " (" + first_few(alone) + "); the first misses by " +
                          length_text(off),
                      "move the plane, set tolerance_m, give a mesh that is symmetric (half = true makes one from its "
                      "half), or remove mesh.symmetry");
  }
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (image[image[i]] != i)
      throw input_error(plane.where.prefix() + "two nodes have the same mirror image",
                        "nodes " + std::to_string(i) + " and " + std::to_string(image[image[i]]),
                        "make tolerance_m smaller than the distance between nodes");
  return image;
}

void check_cells(const Mesh& mesh, const SymmetryPlane& plane, const std::vector<std::int32_t>& image) {
  using Corners = std::array<std::int32_t, 4>;
  std::set<Corners> cells;
  const auto corners = [&](Eigen::Index c, bool mirrored) {
    Corners nodes{};
    nodes.fill(-1);  // triangles have three nodes
    for (Eigen::Index k = 0; k < mesh.cells.cols(); ++k)
      nodes[static_cast<std::size_t>(k)] = mirrored ? image[mesh.cells(c, k)] : mesh.cells(c, k);
    std::sort(nodes.begin(), nodes.end());
    return nodes;
  };
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c) cells.insert(corners(c, false));
  std::vector<std::int32_t> alone;
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c)
    if (!cells.count(corners(c, true))) alone.push_back(static_cast<std::int32_t>(c));
  if (!alone.empty())
    throw input_error(plane.where.prefix() + "the nodes are symmetric, but the cells between them are not",
                      counted(alone.size(), "cell has", "cells have") + " no mirror image: " + first_few(alone),
                      "mesh one half and give it with half = true, or remove mesh.symmetry");
}

void check_set(const std::vector<std::int32_t>& nodes, const char* what, const SymmetryPlane& plane,
               const std::vector<std::int32_t>& image) {
  for (const auto node : nodes)
    if (!std::binary_search(nodes.begin(), nodes.end(), image[node]))
      throw input_error(
          plane.where.prefix() + "the " + what + " nodes are not symmetric",
          "node " + std::to_string(node) + " is selected, its mirror image " + std::to_string(image[node]) + " is not",
          "widen the selection to both sides of the plane, or remove mesh.symmetry");
}

}  // namespace

RawMesh with_mirror_image(RawMesh half, const Vector& point, const Vector& normal, double tolerance,
                          const std::string& source) {
  const auto n = static_cast<std::int32_t>(half.nodes.size());
  std::vector<std::int32_t> image(half.nodes.size());
  std::size_t before = 0, behind = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    auto& node = half.nodes[i];
    const Vector x(node[0], node[1], node[2]);
    const double height = (x - point).dot(normal);
    const bool on_plane = std::abs(height) <= tolerance;
    if (!on_plane) ++(height > 0 ? before : behind);
    const Vector moved = x - (on_plane ? 1 : 2) * height * normal;
    const std::array<double, 3> at{moved[0], moved[1], moved[2]};
    image[i] = on_plane ? i : static_cast<std::int32_t>(half.nodes.size());
    if (on_plane)
      node = at;
    else
      half.nodes.push_back(at);
  }
  if (before > 0 && behind > 0)
    throw input_error(source + ": half a body lies on one side of the plane of symmetry",
                      std::to_string(before) + " nodes before the plane, " + std::to_string(behind) + " behind it",
                      "correct point_m and normal, or remove half: the file holds the whole body");
  if (before + behind == static_cast<std::size_t>(n))
    throw input_error(source + ": no node lies on the plane of symmetry", "", "correct point_m, or set tolerance_m");

  const std::size_t n_cells = half.tetrahedra.size();
  for (std::size_t c = 0; c < n_cells; ++c) {
    const auto cell = half.tetrahedra[c];
    // The mirror image of a cell has the opposite orientation, so that two corners are exchanged.
    half.tetrahedra.push_back({image[cell[0]], image[cell[2]], image[cell[1]], image[cell[3]]});
  }
  if (n_cells > 0) {
    half.triangles.clear();  // the cut face of the half is inside the whole body
  } else {
    const std::size_t n_triangles = half.triangles.size();
    for (std::size_t t = 0; t < n_triangles; ++t) {
      const auto triangle = half.triangles[t];
      half.triangles.push_back({image[triangle[0]], image[triangle[2]], image[triangle[1]]});
    }
  }
  for (auto& [name, nodes] : half.groups) {
    const auto count = nodes.size();
    for (std::size_t i = 0; i < count; ++i) nodes.push_back(image[nodes[i]]);
    sort_unique(nodes);
  }
  return half;
}

std::vector<std::int32_t> mirror_images(const Scene& scene, const Mesh& mesh) {
  const SymmetryPlane& plane = *scene.mesh.symmetry;
  return pair_nodes(mesh, plane,
                    plane.tolerance_m > 0 ? plane.tolerance_m : mirror_tolerance * extent_of(mesh.nodes).norm());
}

MirrorSymmetry find_mirror(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  const SymmetryPlane& plane = *scene.mesh.symmetry;
  MirrorSymmetry mirror;
  mirror.normal = plane.normal;
  mirror.image = mirror_images(scene, mesh);
  check_cells(mesh, plane, mirror.image);
  check_set(sets.fixed, "fixed", plane, mirror.image);
  check_set(sets.active, "active", plane, mirror.image);
  check_set(sets.output, "output", plane, mirror.image);
  // Of a hemisphere only the directions into the body are solved, whose opposites point out of it.
  mirror.odd = scene.material.law->linear && scene.probe.directions != Directions::hemisphere;
  return mirror;
}

}  // namespace phynness::meshes
