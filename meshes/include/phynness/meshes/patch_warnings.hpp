// Whether a mesh suits the tools of a scene.
#pragma once

#include <cstdint>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Mean length of the surface edges at each of `nodes` that is on the surface: the edges in which the radius of a tool
/// is counted.
std::vector<double> surface_edges_at(const std::vector<std::int32_t>& nodes, const Mesh& mesh);

/// A round tool with a smaller radius than this, in mean edges of the surface around its node, is not resolved.
inline constexpr double fewest_edges_of_a_patch = 2;
/// Warnings about the tools of a scene, one sentence each, with file and line and what would do: patches that the mesh
/// does not resolve or that lose a part to fixed nodes, and spread points between which the tool is not answered.
std::vector<std::string> patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets);
/// Of a spacing with which nearly every node of the part is probed: what it chose, why, and the cost. Otherwise empty.
std::string choice_note(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

}  // namespace phynness
