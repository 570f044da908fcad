// Bodies of the robustness study, which are so small that every element and every ratio can be tried.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <random>
#include <vector>

namespace phynness::robustness {

struct Body {
  Scene scene;
  Mesh mesh;
  NodeSets sets;
};

/// A cube with fixed bottom face and active free surface, meshed by gmsh with five elements along an edge. K/mu is
/// `bulk_to_shear`. Increments are a third of an element size, up to three element sizes.
Body cube(Law law, Element element, double bulk_to_shear, double edge_m = 0.1, double shear_modulus_Pa = 500);
inline constexpr int elements_along_edge = 5, increments_per_element = 3;

/// Reduces the quality (radius ratio) of up to `n` cells without common nodes to `quality`, by moving one interior
/// corner of each towards the opposite face. No cell becomes worse than that.
/// @return number of changed cells
int add_slivers(Mesh& mesh, int n, double quality);

/// A scene file with its mesh and sets.
Body load(const std::string& scene_file);

/// `n` random active nodes without repetition, ascending.
std::vector<std::int32_t> draw_nodes(const NodeSets& sets, int n, unsigned seed);

}  // namespace phynness::robustness
