// Prescribed displacements: the dofs that a tool moves, and their weights.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/scene.hpp>
#include <span>
#include <vector>

#include "discretization.hpp"

namespace phynness {

/// A view of a state or a residual as a vector of Eigen.
template <class Values>
auto as_vector(Values&& values) {
  using Scalar = std::remove_pointer_t<decltype(values.data())>;
  using Vector = std::conditional_t<std::is_const_v<Scalar>, const Eigen::VectorXd, Eigen::VectorXd>;
  return Eigen::Map<Vector>(values.data(), std::ssize(values));
}

/// Dependent dofs x_c = G q + M x_m, where q are the parameters of the path, three displacement components per tool,
/// and the masters x_m remain unknown. A tool that prescribes displacements has no masters. A tool that prescribes a
/// mean sum w_i u_i = d has one dependent point, whose displacement follows from d and from the other points.
///
/// With the residual r the work-conjugate force is G^T r_c, which is the derivative of the energy by q, and equilibrium
/// is r_m + M^T r_c = 0: the nodal forces of a mean are w_i F. The tangent is transformed in the same way (a
/// congruence, so that its inertia is that of the tangent on all displacements that keep the mean).
struct Constraint {
  std::vector<std::int32_t> dofs;     ///< n distinct dofs
  Eigen::MatrixXd G;                  ///< n x n_parameters
  std::vector<std::int32_t> masters;  ///< n_masters dofs, none of them in `dofs` and none fixed
  Eigen::MatrixXd M;                  ///< n x n_masters
  int n_parameters() const { return static_cast<int>(G.cols()); }
  /// `prescribed` + M x_m for every dependent dof. @param prescribed  G q or a change of it, n
  Eigen::VectorXd dependent(std::span<const double> state, const Eigen::VectorXd& prescribed) const;
  /// Sets the dependent dofs of a state or of its derivative.
  void complete(std::span<double> state, const Eigen::VectorXd& prescribed) const;
  /// Adds M^T r_c to r_m. @param residual  n_dofs
  void condense(std::span<double> residual) const;
};

/// The constraint of tools around points of the surface; parameters 3 t + k are the components of tool t's
/// displacement. A round tool moves the mean with the weights int phi N_i dA / int phi dA, where phi is the pressure
/// and N_i are the functions of the element on the surface. A tool of radius 0 moves the mean of the corners of its
/// triangle with their barycentric weights, each together with the P1 hat function around it: 1 at the node and 1/2 at
/// the middles of its surface edges. At a node this prescribes the displacement of the node. Fixed points have no
/// weight; the remaining weights of a round tool are normalized, for linear functions by schema::weight_divisor().
/// @param centers  places of the tools; corners of weight 0 may be -1
/// @param radius   in units of length_m
/// @param fixed    flag of each point
/// @throws Error (input) if all points of a tool are fixed, or if tools are at one place
Constraint tool_constraint(const Discretization& body, const std::vector<SurfacePoint>& centers, double radius,
                           const std::vector<char>& fixed);

/// The weight of each point in the mean that a round tool prescribes. The nodal forces are these weights times the
/// force of the tool. All weights are zero if all points of the tool are fixed.
std::vector<double> mean_weights(const Discretization& body, const SurfacePoint& center, double radius,
                                 const std::vector<char>& fixed);

/// Flags of the fixed points: fixed nodes, and middles of edges between two fixed nodes.
std::vector<char> fixed_points(const Discretization& body, std::span<const std::int32_t> fixed_nodes);
std::vector<std::int32_t> displacement_dofs(const Discretization& body, const std::vector<char>& points);
/// Fixed dofs: the displacements of fixed points and, for a clamped shell, the directors between two fixed nodes.
std::vector<std::int32_t> fixed_dofs(const Discretization& body, const std::vector<char>& fixed);

}  // namespace phynness
