// Bodies that are their own mirror image: made from a half, and checked node by node.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <string>

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// How far a node may lie from where its mirror image should be, relative to the body's diagonal, if the
/// scene does not say: what is left of coordinates in files with seven digits.
inline constexpr double mirror_tolerance = 1e-6;

/// Adds the mirror image of half a body. Nodes within `tolerance` of the plane are put on it and shared; the
/// others are followed by their images in the same order, and so are the cells. Images belong to the groups
/// of their nodes.
/// @param point, normal  of the plane; lengths in units of half.nodes; the normal is unit
/// @throws Error (input) if nodes lie on both sides of the plane, or none on it
RawMesh with_mirror_image(RawMesh half, const Eigen::RowVector3d& point, const Eigen::RowVector3d& normal,
                          double tolerance, const std::string& source);

/// Pairs every node with the node at its mirror image (hash grid) and checks that cells and node sets are
/// symmetric.
/// @throws Error (input) that counts what has no image and names the first
MirrorSymmetry find_mirror(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

}  // namespace phynness::meshes
