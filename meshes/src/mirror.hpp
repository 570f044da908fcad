// Bodies with a plane of symmetry: completed from a half, and checked node by node.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Default distance of a node from the mirror image of its partner, relative to the diagonal of the body: the precision
/// of coordinates in files with seven digits.
inline constexpr double mirror_tolerance = 1e-6;

/// Adds the mirror image of half a body. Nodes within `tolerance` of the plane are moved onto it and shared. The images
/// of all other nodes follow in the same order, and so do cells. Images belong to the groups of their nodes.
/// @param point, normal  of the plane; lengths in units of half.nodes; the normal is unit
/// @throws Error (input) if nodes lie on both sides of the plane, or none on it
RawMesh with_mirror_image(RawMesh half, const Eigen::RowVector3d& point, const Eigen::RowVector3d& normal,
                          double tolerance, const std::string& source);

/// The node at the mirror image of each node. @pre the scene declares a plane of symmetry
/// @throws Error (input) if a node has no image
std::vector<std::int32_t> mirror_images(const Scene& scene, const Mesh& mesh);

/// Pairs every node with the node at its mirror image and checks the symmetry of cells and node sets.
/// @throws Error (input) with the number of nodes or cells without an image, and the first of them
MirrorSymmetry find_mirror(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

}  // namespace phynness::meshes
