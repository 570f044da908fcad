// Bodies of the robustness study: small enough that every element and every ratio can be tried.
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

/// A cube held at its bottom face, free surface active, meshed by gmsh with five elements along an edge.
/// K/mu is `bulk_to_shear`; increments of a third of an element size, to three element sizes.
Body cube(Law law, Element element, double bulk_to_shear, double edge_m = 0.1, double shear_modulus_Pa = 500);
inline constexpr int elements_along_edge = 5, increments_per_element = 3;

/// Flattens up to `n` cells that share no node to quality `quality` (radius ratio) by moving one interior
/// corner each towards the face opposite; no cell becomes worse than that.
/// @return how many cells have been flattened
int add_slivers(Mesh& mesh, int n, double quality);

/// A scene file with its mesh and sets.
Body load(const std::string& scene_file);

/// `n` of the active nodes, drawn without repeats; ascending.
std::vector<std::int32_t> draw_nodes(const NodeSets& sets, int n, unsigned seed);

}  // namespace phynness::robustness
