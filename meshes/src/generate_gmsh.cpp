#include <gmsh.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <phynness/formats/error.hpp>

#include "generate.hpp"
#include "gmsh_session.hpp"
#include "mirror.hpp"

namespace phynness::meshes {
namespace {

/// Reference volume of the raw mesh, for any orientation of its cells.
double volume(const RawMesh& raw) {
  double six = 0;
  for (const auto& cell : raw.tetrahedra) {
    const auto& a = raw.nodes[cell[0]];
    double e[3][3];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) e[i][k] = raw.nodes[cell[i + 1]][k] - a[k];
    six +=
        std::abs(e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) - e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                 e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]));
  }
  return six / 6;
}

}  // namespace

RawMesh fill(const Surface& surface) {
  // gmsh compares with absolute tolerances, so that lengths are given in edge lengths for bodies of any size.
  const double unit = mean_edge(surface.nodes, surface.triangles);
  const GmshSession session;
  RawMesh raw;
  session.run("fill the surface with tetrahedra", [&] {
    gmsh::model::addDiscreteEntity(2, 1);
    std::vector<std::size_t> tags(static_cast<std::size_t>(surface.nodes.rows()));
    std::iota(tags.begin(), tags.end(), std::size_t{1});
    std::vector<double> x;
    for (Eigen::Index i = 0; i < surface.nodes.size(); ++i) x.push_back(surface.nodes.data()[i] / unit);
    gmsh::model::mesh::addNodes(2, 1, tags, x);
    std::vector<std::size_t> elements(static_cast<std::size_t>(surface.triangles.rows())), nodes;
    std::iota(elements.begin(), elements.end(), std::size_t{1});
    for (Eigen::Index i = 0; i < surface.triangles.size(); ++i)
      nodes.push_back(static_cast<std::size_t>(surface.triangles.data()[i]) + 1);
    gmsh::model::mesh::addElementsByType(1, 2, elements, nodes);
    gmsh::model::geo::addSurfaceLoop({1}, 1);
    gmsh::model::geo::addVolume({1}, 1);
    gmsh::model::geo::synchronize();
    gmsh::model::mesh::generate(3);

    raw = session.tetrahedra();
  });
  // The given nodes are restored exactly, because division and multiplication by the unit round them.
  for (std::size_t i = 0; i < raw.nodes.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(i);
      raw.nodes[i][k] = row < surface.nodes.rows() ? surface.nodes(row, k) : raw.nodes[i][k] * unit;
    }
  const double wanted = enclosed_volume(surface.nodes, surface.triangles), got = volume(raw);
  if (!(std::abs(got - wanted) <= 1e-6 * wanted))
    throw failure("gmsh's tetrahedra do not fill the inside of the surface",
                  std::to_string(got) + " of " + std::to_string(wanted) + " m^3",
                  "check the surface for triangles that intersect, or change mesh.target_size_m");
  return raw;
}

RawMesh mesh_solid(const Solid& solid, double edge_m) {
  const double unit = edge_m;
  const bool round = solid.shape != Shape::block;
  // gmsh's mesh of a symmetric shape is not symmetric, so that a half is meshed and mirrored.
  const int axis = solid.mirror_axis;
  Vec3 size_m = round ? Vec3{solid.radius_m, solid.radius_m, solid.length_m} : solid.size_m;
  if (axis >= 0 && !(round && axis < 2)) size_m[axis] /= 2;
  // Regular shapes have many points at equal distances, among which gmsh selects by rounding errors. With dimensions
  // rounded to seven digits the mesh does not depend on the unit of length. The nodes are then scaled to the exact
  // size.
  const auto in_edges = [unit](double length_m) {
    constexpr int bits = 24;
    int exponent = 0;
    const double fraction = std::frexp(length_m / unit, &exponent);
    return std::ldexp(std::round(std::ldexp(fraction, bits)), exponent - bits);
  };
  const Vec3 size{in_edges(size_m[0]), in_edges(size_m[1]), in_edges(size_m[2])};
  const GmshSession session;
  RawMesh raw;
  session.run("mesh the built-in shape", [&] {
    if (!round) {
      gmsh::model::occ::addBox(0, 0, 0, size[0], size[1], size[2]);
    } else {
      const double angle = (axis == 0 || axis == 1 ? 1 : 2) * std::numbers::pi;  // half: y >= 0
      const int outer = gmsh::model::occ::addCylinder(0, 0, 0, 0, 0, size[2], size[0], -1, angle);
      if (solid.shape == Shape::tube) {
        const int hole =
            gmsh::model::occ::addCylinder(0, 0, 0, 0, 0, size[2], in_edges(solid.inner_radius_m), -1, angle);
        gmsh::vectorpair result;
        std::vector<gmsh::vectorpair> map;
        gmsh::model::occ::cut({{3, outer}}, {{3, hole}}, result, map);
      }
    }
    gmsh::model::occ::synchronize();
    // The given size determines the edges on faces and inside. Otherwise the integer number of pieces of each edge
    // would determine them, and the number of nodes would jump.
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
    gmsh::option::setNumber("Mesh.MeshSizeMin", 1);
    gmsh::option::setNumber("Mesh.MeshSizeMax", 1);
    gmsh::model::mesh::generate(3);
    raw = session.tetrahedra();
  });
  for (auto& x : raw.nodes)
    for (std::size_t k = 0; k < 3; ++k) x[k] *= size_m[k] / size[k];
  if (axis < 0) return raw;
  if (round && axis == 0)
    for (auto& x : raw.nodes) x = {x[1], -x[0], x[2]};  // rotation by 90 degrees: the half x >= 0
  Eigen::RowVector3d normal = Eigen::RowVector3d::Zero(), point = normal;
  normal[axis] = 1;
  // Round halves begin at the axis of the shape; all others lie in [0, middle].
  if (!(round && axis < 2)) point[axis] = size_m[axis];
  return with_mirror_image(std::move(raw), point, normal, 1e-6 * unit, "the built-in shape");
}

}  // namespace phynness::meshes
