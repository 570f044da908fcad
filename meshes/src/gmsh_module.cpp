#include "gmsh_module.hpp"

#include <gmsh.h>

#include <numbers>
#include <numeric>

#include "gmsh_session.hpp"

namespace phynness::meshes {
namespace {

/// The given size determines the edges on faces and inside. Otherwise the integer number of pieces of each edge would
/// determine them, and the number of nodes would jump.
void generate_unit_edges(int dimension) {
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
  gmsh::option::setNumber("Mesh.MeshSizeMin", 1);
  gmsh::option::setNumber("Mesh.MeshSizeMax", 1);
  gmsh::model::mesh::generate(dimension);
}

RawMesh fill_surface(const Surface& surface) {
  const GmshSession session;
  RawMesh raw;
  session.run("fill the surface with tetrahedra", [&] {
    gmsh::model::addDiscreteEntity(2, 1);
    std::vector<std::size_t> tags(static_cast<std::size_t>(surface.nodes.rows()));
    std::iota(tags.begin(), tags.end(), std::size_t{1});
    const std::vector<double> x(surface.nodes.data(), surface.nodes.data() + surface.nodes.size());
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
  return raw;
}

RawMesh solid(Shape shape, const Vec3& size, double inner_radius, double angle) {
  namespace occ = gmsh::model::occ;
  const GmshSession session;
  RawMesh raw;
  session.run("mesh the built-in shape", [&] {
    if (shape == Shape::block) {
      occ::addBox(0, 0, 0, size[0], size[1], size[2]);
    } else {
      const int outer = occ::addCylinder(0, 0, 0, 0, 0, size[2], size[0], -1, angle);
      if (shape == Shape::tube) {
        const int hole = occ::addCylinder(0, 0, 0, 0, 0, size[2], inner_radius, -1, angle);
        gmsh::vectorpair result;
        std::vector<gmsh::vectorpair> map;
        occ::cut({{3, outer}}, {{3, hole}}, result, map);
      }
    }
    occ::synchronize();
    generate_unit_edges(3);
    raw = session.tetrahedra();
  });
  return raw;
}

RawMesh drain(const Drain& drain) {
  const double radius = drain.radius_m, length = drain.length_m;
  constexpr double quarter_turn = std::numbers::pi / 2;
  const int axis = drain.mirror_axis;
  const GmshSession session;
  RawMesh raw;
  session.run("mesh the drain", [&] {
    namespace occ = gmsh::model::occ;
    const int circle = occ::addCircle(0, 0, 0, radius);
    gmsh::vectorpair walls;
    occ::extrude({{1, circle}}, 0, 0, length, walls);
    gmsh::vectorpair tube;
    for (const auto& entity : walls)
      if (entity.first == 2) tube.push_back(entity);
    // An ellipse with its long axis along the tube, extruded through the upper wall only.
    const gmsh::vectorpair disk{{2, occ::addDisk(0, 0, 0, drain.slit_length_m / 2, drain.slit_width_m / 2)}};
    occ::rotate(disk, 0, 0, 0, 0, 1, 0, quarter_turn);
    occ::rotate(disk, 0, 0, 0, 0, 0, 1, quarter_turn);
    occ::translate(disk, 0, 0, length / 2);
    gmsh::vectorpair cutter, bodies, left;
    occ::extrude(disk, 0, 2 * radius, 0, cutter);
    for (const auto& entity : cutter)
      if (entity.first == 3) bodies.push_back(entity);
    std::vector<gmsh::vectorpair> map;
    occ::cut(tube, bodies, left, map);
    // gmsh's mesh of a symmetric shape is not symmetric, so that a half is meshed and mirrored.
    if (axis >= 0) {
      const double reach = 2 * radius, height = axis == 2 ? length / 2 : length;
      const int half = occ::addBox(axis == 0 ? 0 : -reach, -reach, 0, axis == 0 ? reach : 2 * reach, 2 * reach, height);
      const gmsh::vectorpair whole = left;
      occ::intersect(whole, {{3, half}}, left, map);
    }
    occ::synchronize();
    generate_unit_edges(2);
    raw = session.triangles();
  });
  return raw;
}

}  // namespace

const GmshModule phynness_gmsh{fill_surface, solid, drain};

}  // namespace phynness::meshes
