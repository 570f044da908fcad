// What comparisons of elements and meshes have in common.
#pragma once

#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

/// Without measurements the CPU time of a solve is assumed to grow with this power of the unknowns; measured powers are
/// between 1.6 (p1-p1, 736 to 4,298 nodes) and 2.1 (p1-p1 and Taylor-Hood).
constexpr double cost_exponent = 2;

/// The scene as its forces are compared: with few increments, a round tool in place of a node, and nothing stored.
Scene compared_scene(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

double unknowns_of(Element element, double nodes, double edges);

}  // namespace phynness
