// Prescribed displacements: which dofs a tool moves, and with what weights.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/scene.hpp>
#include <span>
#include <vector>

#include "discretization.hpp"

namespace phynness {

/// Prescribed dofs x_c = G q: q holds the parameters of the path, three displacement components per tool.
/// The work-conjugate force is G^T r_c, r the residual, so that it is the derivative of the energy by q.
struct Constraint {
  std::vector<std::int32_t> dofs;  ///< n, without repeats
  Eigen::MatrixXd G;               ///< n x n_parameters
  int n_parameters() const { return static_cast<int>(G.cols()); }
};

/// Weight of every point of the body under a tool at `node` (DESIGN section 3), zero where `fixed`.
/// node: the P1 hat on the surface, 1 at the node and 1/2 at the middles of its surface edges.
/// patch: touched_nodes(), and the same bump at the middles of surface edges that end in one of them.
/// @param fixed  per point
std::vector<double> tool_weights(const Discretization& body, ProbeKind kind, double radius, std::int32_t node,
                                 const std::vector<char>& fixed);

/// Several tools at once: parameters 3 t + k are the components of tool t's displacement.
Constraint tool_constraint(const Discretization& body, const std::vector<std::vector<double>>& weights_of_tools);

/// Points held at zero: fixed nodes, and middles of edges between two of them.
std::vector<char> fixed_points(const Discretization& body, std::span<const std::int32_t> fixed_nodes);
std::vector<std::int32_t> displacement_dofs(const Discretization& body, const std::vector<char>& points);
/// Dofs that fixed points hold: displacements and, of a shell, directors between two fixed nodes: it is clamped.
std::vector<std::int32_t> fixed_dofs(const Discretization& body, const std::vector<char>& fixed);

}  // namespace phynness
