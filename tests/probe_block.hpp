// A soft block of some centimetres, fixed at its bottom and touched on top: the smallest scene with all parts.
#pragma once

#include <phynness/precompute/probe_solver.hpp>

#include "block_mesh.hpp"
#include "solver_cases.hpp"

namespace phynness::test {

inline std::int32_t nearest_node(const Mesh& mesh, const Vec3& point) {
  Eigen::Index node = 0;
  (mesh.nodes.rowwise() - Eigen::RowVector3d(point[0], point[1], point[2])).rowwise().squaredNorm().minCoeff(&node);
  return static_cast<std::int32_t>(node);
}

struct ProbeBlock {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
  std::int32_t top = 0;  ///< the middle of the upper face

  ProbeSolver solver() const { return {scene, mesh, sets}; }
  /// A solver whose one tool holds the top.
  ProbeSolver touched() const {
    auto s = solver();
    s.touch({top});
    return s;
  }
};

inline constexpr Vec3 block_size_m{0.10, 0.08, 0.06};

/// Shear modulus 500 Pa, as the liver of the paper. @param boxes  even in x and y
inline ProbeBlock probe_block(const Case& c, double bulk_to_shear, const std::array<int, 3>& boxes) {
  ProbeBlock block;
  // Of a database only the kind of directions is read from it.
  block.scene.text = R"([mesh]
shape = "block"
[material]
law = "neo-hookean"
c10_Pa = 250.0
bulk_modulus_Pa = 5e3
[nodes]
fixed = { plane = { point_fraction = [0, 0, 0], normal = [0, 0, 1], tolerance_m = 1e-6 } }
[probe]
kind = "node"
max_displacement_m = 0.008
)";
  block.scene.material = times(500, unit_material(c.law, bulk_to_shear));
  block.scene.solver.element = c.element;
  block.mesh = block_mesh(boxes, block_size_m);
  for (std::int32_t i = 0; i < block.mesh.n_nodes(); ++i)
    if (block.mesh.nodes(i, 2) == 0) block.sets.fixed.push_back(i);
  block.top = nearest_node(block.mesh, {block_size_m[0] / 2, block_size_m[1] / 2, block_size_m[2]});
  block.sets.active = {block.top};
  block.sets.tools = single_nodes(block.sets.active);
  return block;
}

}  // namespace phynness::test
