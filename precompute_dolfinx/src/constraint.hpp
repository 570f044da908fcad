// Prescribed displacements: the dofs that a tool moves, and their weights.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/scene.hpp>
#include <phynness/formats/tool.hpp>
#include <span>
#include <vector>

#include "discretization.hpp"

namespace phynness {

/// Prescribed dofs x_c = G q, where q are the parameters of the path, three displacement components per tool. With the
/// residual r the work-conjugate force is G^T r_c, which is the derivative of the energy by q.
struct Constraint {
  std::vector<std::int32_t> dofs;  ///< n, without repeats
  Eigen::MatrixXd G;               ///< n x n_parameters
  int n_parameters() const { return static_cast<int>(G.cols()); }
};

/// Weight of every point of the body under a tool at `node`, zero at fixed points.
/// Node probe: the P1 hat function on the surface, 1 at the node and 1/2 at the middles of its surface edges.
/// Patch probe: the weights of touched_nodes(), and the same function at the middles of surface edges that end at one
/// of these nodes.
/// @param fixed  flag of each point
std::vector<double> tool_weights(const Discretization& body, ProbeKind kind, double radius, std::int32_t node,
                                 const std::vector<char>& fixed);
/// The same of a patch around a point of the surface (touched_nodes). @param radius  > 0
/// @throws Error (input) if the patch holds no free node of the point's triangle
std::vector<double> patch_weights(const Discretization& body, double radius, const SurfacePoint& center,
                                  const std::vector<char>& fixed);
/// Fixed nodes, ascending. @param fixed  flag of each point
std::vector<std::int32_t> fixed_nodes(const Discretization& body, const std::vector<char>& fixed);

/// The constraint of several tools; parameters 3 t + k are the components of tool t's displacement.
Constraint tool_constraint(const Discretization& body, const std::vector<std::vector<double>>& weights_of_tools);

/// Flags of the points that are held at zero: fixed nodes, and middles of edges between two fixed nodes.
std::vector<char> fixed_points(const Discretization& body, std::span<const std::int32_t> fixed_nodes);
std::vector<std::int32_t> displacement_dofs(const Discretization& body, const std::vector<char>& points);
/// Dofs held by fixed points: displacements and, for a shell, directors between two fixed nodes, where it is clamped.
std::vector<std::int32_t> fixed_dofs(const Discretization& body, const std::vector<char>& fixed);

}  // namespace phynness
