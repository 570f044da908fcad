// The nodes that a tool holds, with their weights, and a check that the fixed nodes hold the body.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <string>
#include <vector>

namespace phynness {

/// A point of the undeformed surface: a triangle's nodes and barycentric weights, >= 0 and of sum 1.
struct SurfacePoint {
  std::array<std::int32_t, 3> nodes{};
  std::array<double, 3> weights{};
  Vec3 point{};         ///< [m]
  double distance = 0;  ///< from the given point [m]
};
/// The corners of a triangle, one in each column.
Eigen::Matrix3d corners_of(const Points& nodes, const Triangles& surface, Eigen::Index t);
/// Its normal, by the order of the corners, with twice the area as length.
Eigen::Vector3d normal_of(const Eigen::Matrix3d& corners);
/// Barycentric weights of the point of a triangle that is nearest to x. @param corners  as corners_of()
Eigen::Vector3d nearest_in_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& x);
/// The point of the surface nearest to x [m]. @pre surface has triangles
SurfacePoint nearest_on_surface(const Points& nodes, const Triangles& surface, const Vec3& x);

/// What a tool moves: nodes of the surface in ascending order, with weights w.
struct TouchedNodes {
  std::vector<std::int32_t> nodes;
  std::vector<double> weights;
  /// Whether the weighted mean sum w_i u_i follows the tool. Otherwise every node does: u_i = w_i d.
  bool mean = false;
  /// Whether the tool prescribes the displacement of this node.
  bool holds(std::int32_t node) const { return !mean && std::binary_search(nodes.begin(), nodes.end(), node); }
};

/// Pressure under a round tool of radius R at the squared distance s2 = (r / R)^2 from its middle, up to a factor: even
/// (docs/decisions/round-tool.md), and 0 from the rim on.
double tool_pressure(double s2);
/// Receives a point of a surface triangle, by its barycentric coordinates, and its part of the integral
/// of the pressure.
using TakePressure = std::function<void(Eigen::Index triangle, const Eigen::Vector3d& at, double part)>;
/// Integrates the pressure of a round tool over the surface by midpoint rules on triangles that are halved until they
/// are small compared to the tool, and smaller still at its rim; the parts are not normalized. Included are the
/// triangles that are connected to the tool's middle over edges within its radius (straight distance), with the factor
/// max(0, n . n_0) of the normals here and at the middle (docs/decisions/facing-tool.md), so that a tool wider than the
/// body is thick does not press the far side, and around a rim the pressure fades.
/// @param center  its nodes and weights are used; corners of weight 0 may be -1
/// @param whole   without this factor, as in databases before it
/// @pre radius > 0
void integrate_pressure(const Points& nodes, const Triangles& surface, const SurfacePoint& center, double radius,
                        bool whole, const TakePressure& take);

/// The nodes that a tool moves, without fixed nodes. A tool of radius 0 moves the corners of its triangle, with their
/// barycentric weights. A round tool moves the mean with the weights int phi N_i dA / int phi dA, where phi is
/// the pressure and N_i is the linear function of node i on the surface; without the fixed nodes the weights are
/// normalized again. Its forces on the nodes are w_i F.
/// @param nodes, surface  of the mesh; any unit, the same as radius
/// @param fixed           fixed nodes, ascending
/// @throws Error (input) if nothing is left of the tool
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           const SurfacePoint& center, double radius, bool whole = false);
/// Of a database's tool at a node, also of one that was computed when a patch was rigid or pressed the whole surface
/// within its radius.
TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           std::int32_t node, const ProbeSpec& probe);
SurfacePoint at_node(std::int32_t node);

/// Mean length of the surface edges at each of `nodes` that is on the surface: the edges in which the radius of a tool
/// is counted.
std::vector<double> surface_edges_at(const std::vector<std::int32_t>& nodes, const Mesh& mesh);

/// A round tool with a smaller radius than this, in mean edges of the surface around its node, is not resolved.
inline constexpr double fewest_edges_of_a_patch = 2;
/// Warnings about the tools of a scene, one sentence each, with file and line and what would do: patches that the mesh
/// does not resolve or that lose a part to fixed nodes, and spread points between which the tool is not answered.
std::vector<std::string> patch_warnings(const Scene& scene, const Mesh& mesh, const NodeSets& sets);

/// True if the fixed nodes prevent every rigid motion: at least three nodes that are not on one line, or an edge of a
/// shell, which is clamped there. A singular factorization does not detect this reliably, because rounding turns its
/// zero pivots into small numbers.
bool hold_the_body(const Mesh& mesh, std::span<const std::int32_t> fixed);

}  // namespace phynness
