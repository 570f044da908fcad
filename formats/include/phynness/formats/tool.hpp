// Which nodes a tool holds and how firmly, and whether the fixed ones hold the body: rules that stages share.
#pragma once

#include <array>
#include <cstdint>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <vector>

namespace phynness {

/// Nodes moved by a tool and their weights w: u_i = w_i d. Ascending; the touched node itself is there with
/// weight 1.
struct TouchedNodes {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
};

/// Weight at squared distance s2 = (distance / tool radius)^2: the bump (1 - s2)^2, zero from the rim on.
/// The rim itself is free whichever way rounding goes: to hold it at zero would be another scene.
inline double patch_weight(double s2) { return s2 < 1 - 1e-9 ? (1 - s2) * (1 - s2) : 0.0; }

/// @param nodes, surface  of the mesh; any unit, the same as tool_radius
/// @param fixed           fixed nodes, ascending; a tool does not move them
/// @param tool_radius     0: a node probe, which moves `node` alone. Else a patch: the surface nodes within
/// the radius
///                        (straight distance) that can be reached from `node` over surface edges between such
///                        nodes, so that a tool wider than the body is thick does not hold its far side.
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           std::int32_t node, double tool_radius);

/// True if no rigid motion leaves the fixed nodes where they are: at least three of them, not on one line, or an
/// edge of a shell, which is clamped there.
/// A singular factorization does not show this reliably, as rounding makes its zero pivots small numbers.
bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed);

/// A point of the undeformed surface: a triangle's nodes and barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  Vec3 point{};         ///< [m]
  double distance = 0;  ///< from where it was looked for [m]
};
/// The point of the surface nearest to x [m]. @pre surface has triangles
SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x);

}  // namespace phynness
