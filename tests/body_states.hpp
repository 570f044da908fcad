// States, supports and loads of a discretized body, by the coordinates of its points.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <functional>
#include <map>
#include <vector>

#include "closed_forms.hpp"
#include "solve/discretization.hpp"
#include "solve/equilibrium.hpp"

namespace phynness::test {

using Vector3 = Eigen::Vector3d;

/// Displacement u(X) at every point; pressures zero.
inline std::vector<double> state_of(const Discretization& body, const std::function<Vector3(const Vector3&)>& u) {
  std::vector<double> state(body.n_dofs(), 0.0);
  for (int p = 0; p < body.n_points(); ++p) {
    const Vector3 value = u(body.points().row(p).transpose());
    for (int k = 0; k < 3; ++k) state[body.dofs(p)[k]] = value[k];
  }
  return state;
}

/// The homogeneous state of deformation gradient F, with its pressure.
inline std::vector<double> homogeneous_state(const Discretization& body, const Material& material,
                                             const Eigen::Matrix3d& F) {
  auto state = state_of(body, [&](const Vector3& X) -> Vector3 { return F * X - X; });
  for (const auto dof : body.pressure_dofs()) state[dof] = pressure(material, F);
  return state;
}

inline Vector3 value_at(const Discretization& body, const std::vector<double>& values, int point) {
  const auto& dofs = body.dofs(point);
  return {values[dofs[0]], values[dofs[1]], values[dofs[2]]};
}

/// Boundary displaced by u = H X; the nine parameters are H row by row, so the conjugate force is volume times P.
inline Constraint affine_boundary(const Discretization& body) {
  Constraint constraint;
  for (int p = 0; p < body.n_points(); ++p)
    if (body.on_surface(p)) constraint.dofs.insert(constraint.dofs.end(), body.dofs(p).begin(), body.dofs(p).end());
  constraint.G = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(constraint.dofs.size()), 9);
  Eigen::Index row = 0;
  for (int p = 0; p < body.n_points(); ++p)
    if (body.on_surface(p))
      for (int k = 0; k < 3; ++k, ++row) constraint.G.block<1, 3>(row, 3 * k) = body.points().row(p);
  return constraint;
}

/// Component k of all points with X_k = 0 held, for each k: symmetry planes of an octant.
inline std::vector<std::int32_t> rollers(const Discretization& body) {
  std::vector<std::int32_t> dofs;
  for (int p = 0; p < body.n_points(); ++p)
    for (int k = 0; k < 3; ++k)
      if (body.points()(p, k) == 0) dofs.push_back(body.dofs(p)[k]);
  return dofs;
}

/// Nodal forces of a dead traction on the flat surface triangles whose three nodes satisfy `on_face`: the
/// integrals of the shape functions are area/3 at the nodes of linear elements; of quadratic ones zero at the
/// nodes and area/3 at the middles of edges.
inline std::vector<double> dead_traction(const Discretization& body, const Mesh& mesh, const Vector3& traction,
                                         const std::function<bool(const Vector3&)>& on_face) {
  std::map<std::array<std::int32_t, 2>, int> point_of_edge;
  for (int p = body.n_nodes(); p < body.n_points(); ++p) point_of_edge[body.edge(p)] = p;
  std::vector<double> load(body.n_dofs(), 0.0);
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t) {
    std::array<Vector3, 3> corners;
    for (int i = 0; i < 3; ++i) corners[i] = mesh.nodes.row(mesh.surface(t, i)).transpose();
    if (!on_face(corners[0]) || !on_face(corners[1]) || !on_face(corners[2])) continue;
    const double area = (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm() / 2;
    for (int i = 0; i < 3; ++i) {
      const auto a = mesh.surface(t, i), b = mesh.surface(t, (i + 1) % 3);
      const int point = point_of_edge.empty() ? a : point_of_edge.at({std::min(a, b), std::max(a, b)});
      for (int k = 0; k < 3; ++k) load[body.dofs(point)[k]] += traction[k] * area / 3;
    }
  }
  return load;
}

/// A dead load: nodal forces that do not depend on the state.
class DeadLoad : public BlockEnergy {
 public:
  /// @param load  n_dofs, dimensionless. @param factor  multiplies the load
  explicit DeadLoad(const std::vector<double>& load, double factor = 1) : _load(factor * as_vector(load)) {}
  double energy(std::span<const double> state) const override { return -_load.dot(as_vector(state)); }
  void add_residual(std::span<const double>, std::span<double> out) const override { as_vector(out) -= _load; }
  void add_tangent(std::int32_t, std::span<const double>, std::span<double>) const override {}

 private:
  Eigen::VectorXd _load;
};

/// Raises the load in equal steps and solves each; expects every step to converge.
inline void solve_in_steps(Discretization& body, Equilibrium& equilibrium, const std::vector<double>& load, int steps,
                           std::vector<double>& state) {
  for (int i = 1; i <= steps; ++i) {
    const DeadLoad part(load, static_cast<double>(i) / steps);
    body.set_extra_energy(&part);
    ASSERT_EQ(equilibrium.solve(state).status, Status::converged) << "load step " << i << " of " << steps;
    body.set_extra_energy(nullptr);
  }
}

}  // namespace phynness::test
