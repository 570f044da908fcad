#include <gmsh.h>

#include "generate.hpp"
#include "gmsh_session.hpp"
#include "mirror.hpp"

namespace phynness::meshes {

RawMesh mesh_drain(const Drain& drain, double edge_m) {
  // gmsh compares with absolute tolerances, so that lengths are given in edge lengths.
  const double radius = drain.radius_m / edge_m, length = drain.length_m / edge_m;
  const double slit_length = drain.slit_length_m / edge_m, slit_width = drain.slit_width_m / edge_m;
  constexpr double quarter_turn = 1.5707963267948966;
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
    const gmsh::vectorpair disk{{2, occ::addDisk(0, 0, 0, slit_length / 2, slit_width / 2)}};
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
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 0);
    gmsh::option::setNumber("Mesh.MeshSizeMin", 1);
    gmsh::option::setNumber("Mesh.MeshSizeMax", 1);
    gmsh::model::mesh::generate(2);
    raw = session.triangles();
  });
  for (auto& x : raw.nodes)
    for (auto& component : x) component *= edge_m;
  if (axis < 0) return raw;
  Eigen::RowVector3d normal = Eigen::RowVector3d::Zero(), point = normal;
  normal[axis] = 1;
  if (axis == 2) point[axis] = drain.length_m / 2;
  return with_mirror_image(std::move(raw), point, normal, 1e-6 * edge_m, "shape 'drain'");
}

}  // namespace phynness::meshes
