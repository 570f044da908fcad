#include "bodies.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <phynness/meshes/meshes.hpp>
#include <set>

namespace phynness::robustness {
namespace {

/// The cells around a node as a separate mesh, for measure_quality.
Mesh around(const Mesh& mesh, std::int32_t node) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index c = 0; c < mesh.cells.rows(); ++c)
    if ((mesh.cells.row(c).array() == node).any()) rows.push_back(c);
  Mesh part;
  part.nodes = mesh.nodes;
  part.cells.resize(static_cast<Eigen::Index>(rows.size()), 4);
  for (std::size_t i = 0; i < rows.size(); ++i) part.cells.row(static_cast<Eigen::Index>(i)) = mesh.cells.row(rows[i]);
  return part;
}

double height_over_face(const Mesh& mesh, Eigen::Index cell, int corner, Eigen::RowVector3d& normal) {
  const auto at = [&](int k) -> Eigen::RowVector3d { return mesh.nodes.row(mesh.cells(cell, (corner + k) % 4)); };
  normal = (at(2) - at(1)).cross(at(3) - at(1)).normalized();
  return (at(0) - at(1)).dot(normal);
}

bool all_positive(const Mesh& part) {
  for (Eigen::Index c = 0; c < part.cells.rows(); ++c) {
    const Eigen::RowVector3d a = part.nodes.row(part.cells(c, 0));
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.row(k) = part.nodes.row(part.cells(c, k + 1)) - a;
    if (!(edges.determinant() > 0)) return false;
  }
  return true;
}

}  // namespace

Body cube(Law law, Element element, double bulk_to_shear, double edge_m, double shear_modulus_Pa) {
  Body body;
  Scene& scene = body.scene;
  scene.mesh.shape = Shape::block;
  scene.mesh.size_m = {edge_m, edge_m, edge_m};
  scene.mesh.target_size_m = edge_m / elements_along_edge;
  const double bulk_Pa = bulk_to_shear * shear_modulus_Pa;
  // The ratio of C01 to mu of the Penrose drain.
  const double c01_Pa = shear_modulus_Pa / 22;
  scene.material =
      law == law_named("mooney-rivlin")
          ? material_of(law,
                        {{"c10_Pa", shear_modulus_Pa / 2 - c01_Pa}, {"c01_Pa", c01_Pa}, {"bulk_modulus_Pa", bulk_Pa}})
          : material_of(law, {{"shear_modulus_Pa", shear_modulus_Pa}, {"bulk_modulus_Pa", bulk_Pa}});
  scene.solver.element = element;
  scene.fixed = parse_selection(fmt::format(
      "{{ plane = {{ point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = {} }} }}", 1e-6 * edge_m));
  scene.active = scene.output = parse_selection("\"free-surface\"");
  scene.probe.max_displacement_m = 3 * edge_m / elements_along_edge;
  scene.probe.increments = 3 * increments_per_element;
  body.mesh = make_mesh(scene).mesh;
  body.sets = resolve_selections(scene, body.mesh);
  return body;
}

int add_slivers(Mesh& mesh, int n, double quality) {
  std::set<std::int32_t> taken;
  for (const auto node : surface_nodes(mesh.surface)) taken.insert(node);
  int made = 0;
  for (Eigen::Index c = 0; c < mesh.cells.rows() && made < n; ++c)
    for (int corner = 0; corner < 4; ++corner) {
      const std::int32_t node = mesh.cells(c, corner);
      if (taken.count(node)) continue;
      Eigen::RowVector3d normal;
      const double height = height_over_face(mesh, c, corner, normal);
      const Eigen::RowVector3d start = mesh.nodes.row(node);
      Mesh part = around(mesh, node);
      double low = 0, high = 1;  // fraction by which the height is reduced
      for (int i = 0; i < 50; ++i) {
        const double middle = (low + high) / 2;
        part.nodes.row(node) = start - middle * height * normal;
        (all_positive(part) && measure_quality(part).min_quality > quality ? low : high) = middle;
      }
      part.nodes.row(node) = start - low * height * normal;
      // If another cell becomes flat first, this corner is not moved.
      const auto worst = measure_quality(part).worst_cell;
      if ((part.cells.row(worst).array() == mesh.cells.row(c).array()).all()) {
        mesh.nodes.row(node) = part.nodes.row(node);
        for (Eigen::Index i = 0; i < part.cells.size(); ++i) taken.insert(part.cells.data()[i]);
        ++made;
        break;
      }
    }
  return made;
}

Body load(const std::string& scene_file) {
  Body body;
  body.scene = read_scene(scene_file);
  body.mesh = make_mesh(body.scene).mesh;
  body.sets = resolve_selections(body.scene, body.mesh);
  return body;
}

std::vector<std::int32_t> draw_nodes(const NodeSets& sets, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::int32_t> left = sets.active, drawn;
  while (static_cast<int>(drawn.size()) < n && !left.empty()) {
    const auto at = static_cast<std::ptrdiff_t>(random() % left.size());
    drawn.push_back(left[static_cast<std::size_t>(at)]);
    left.erase(left.begin() + at);
  }
  std::sort(drawn.begin(), drawn.end());
  return drawn;
}

}  // namespace phynness::robustness
