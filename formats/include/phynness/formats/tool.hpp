// The nodes that a tool holds, with their weights, and a check that the fixed nodes hold the body.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <string>
#include <vector>

namespace phynness {

/// Nodes moved by a tool, in ascending order, and their weights w: u_i = w_i d. The touched node itself has the
/// weight 1.
struct TouchedNodes {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  double scale = 1;  ///< of patch_weight: 1 except for patches between nodes
};

/// Weight at the squared distance s2 = (distance / tool radius)^2: the function (1 - s2)^2, and 0 from the rim on. The
/// rim itself is always free, independently of rounding: held with weight 0 it would be a fixed node.
inline double patch_weight(double s2) { return s2 < 1 - 1e-9 ? (1 - s2) * (1 - s2) : 0.0; }

/// @param nodes, surface  of the mesh; any unit, the same as tool_radius
/// @param fixed           fixed nodes, ascending, which a tool does not move
/// @param tool_radius     0: a node probe, which moves `node` alone. Else a patch: the surface nodes within the radius
///                        (straight distance) that can be reached from `node` over surface edges between such nodes, so
///                        that a tool wider than the body is thick does not hold its far side.
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           std::int32_t node, double tool_radius);

/// Mean length of the surface edges at each of `nodes` that is on the surface: the edges in which the radius of a tool
/// is counted.
std::vector<double> surface_edges_at(const std::vector<std::int32_t>& nodes, const Mesh& mesh);

/// A patch with a smaller radius than this, in mean edges of the surface around its node, is not resolved.
inline constexpr double fewest_edges_of_a_patch = 2;
/// A patch that is displaced farther sideways than this, in radii, folds over itself: its weight falls by up to 1.54
/// per radius, so that points at its front overtake each other.
inline constexpr double farthest_slide_of_a_patch = 0.65;
/// Warnings about a patch of a scene that its mesh does not resolve or that folds, one sentence each, with file and
/// line and what would do; none for node probes.
std::vector<std::string> patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// True if the fixed nodes prevent every rigid motion: at least three nodes that are not on one line, or an edge of a
/// shell, which is clamped there. A singular factorization does not detect this reliably, because rounding turns its
/// zero pivots into small numbers.
bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed);

/// A point of the undeformed surface: a triangle's nodes and barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  Vec3 point{};         ///< [m]
  double distance = 0;  ///< from the given point [m]
};
/// The point of the surface nearest to x [m]. @pre surface has triangles
SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x);

/// A patch whose center is a point of the surface, with the weights of a patch at a node times one factor: with it the
/// point itself moves by d, sum_k lambda_k w_k = 1 over the corners of its triangle that are not fixed. At a node this
/// is the node's patch.
/// @param center  its nodes and weights are used; corners of weight 0 may be -1
/// @pre tool_radius > 0
/// @throws Error (input) if no free corner of the point's triangle is within the radius
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double tool_radius);

/// Refuses patches that overlap: the probe at a free corner of one moves a free corner of the other.
/// @param moved_by  nodes that the probe of a node moves, ascending
/// @throws Error (input)
void require_apart(std::span<const SurfacePoint> tools, std::span<const std::int32_t> fixed,
                   const std::function<std::vector<std::int32_t>(std::int32_t node)>& moved_by);

}  // namespace phynness
