// Claim: at an equilibrium under a tool that moves a node, a point between nodes or the mean of a round patch,
// linearize() gives dF/dd and dx/dd, which agree with difference quotients of solves at neighbouring displacements. The
// condensed tangent is symmetric.
//
// The solver's tolerance is 1e-12 of the reactions, so that a quotient with step h has an error of 1e-12 F / h. The
// truncation error of the five-point formula is h^4/30 times the fifth derivative. With h = 1 % of the block and forces
// of order 1 these are 1e-10 and about 1e-8. The tolerance is 1e-6 of the norm; a wrong term would change 1e-2.
#include <gtest/gtest.h>
#include <phynness/meshes/tool_weights.hpp>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solve/ray_solver.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

class CondensedTangent : public ::testing::TestWithParam<Case> {
 protected:
  void check(const Eigen::RowVector2d& aside, double radius);
};

TEST_P(CondensedTangent, IsTheDifferenceQuotientOfNeighbouringSolves) { check({0, 0}, 0); }
TEST_P(CondensedTangent, BetweenNodesIsTheDifferenceQuotientOfNeighbouringSolves) { check({0.1, 0.07}, 0); }
TEST_P(CondensedTangent, OfARoundToolIsTheDifferenceQuotientOfNeighbouringSolves) { check({0.1, 0.07}, 0.6); }

/// @param aside  from the middle node of the upper face
void CondensedTangent::check(const Eigen::RowVector2d& aside, double radius) {
  SolverSpec spec;
  spec.element = GetParam().element;
  spec.relative_tolerance = 1e-12;
  Random random(31);
  const auto mesh = irregular(block_mesh({2, 2, 2}, {1, 0.9, 0.8}), 0.08, random);
  Discretization body(mesh, form_set(unit_material(GetParam().law, 10), GetParam().element, 1));
  std::vector<std::int32_t> bottom;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (mesh.nodes(i, 2) == 0) bottom.push_back(i);
  const auto fixed = fixed_points(body, bottom);
  Equilibrium equilibrium(body, displacement_dofs(body, fixed), spec);
  const std::int32_t top = mesh.n_nodes() - 5;  // the middle of the upper face
  const Eigen::RowVector3d at = mesh.nodes.row(top) + Eigen::RowVector3d(aside[0], aside[1], 0);
  equilibrium.prescribe(
      tool_constraint(body, {nearest_on_surface(mesh.nodes, mesh.surface, {at[0], at[1], at[2]})}, radius, fixed));
  RaySolver rays(body, equilibrium, spec);

  const Vector3 d(0.05, 0.03, -0.06);
  std::vector<double> state;
  rays.follow(rays.rest(), d, {0.5, 1.0}, false, [&](std::size_t, const PathStep& step, const PathPoint& point) {
    EXPECT_EQ(step.status, Status::converged);
    state = point.state;
    return true;
  });
  const auto linear = equilibrium.linearize(state, Eigen::Matrix3d::Identity());
  ASSERT_EQ(linear.status, Status::converged);

  Eigen::Matrix3d tangent;
  Eigen::MatrixXd sensitivity(body.n_dofs(), 3);
  const double h = 0.003;
  for (int k = 0; k < 3; ++k) {
    tangent.col(k).setZero();
    sensitivity.col(k).setZero();
    for (const auto& [steps, weight] : {std::pair{-2, 1.0}, {-1, -8.0}, {1, 8.0}, {2, -1.0}}) {
      auto near = state;
      for (int dof = 0; dof < body.n_dofs(); ++dof) near[dof] += linear.sensitivity(dof, k) * steps * h;  // a start
      ASSERT_EQ(equilibrium.solve(near).status, Status::converged);
      tangent.col(k) += weight / (12 * h) * equilibrium.force(near);
      sensitivity.col(k) += weight / (12 * h) * as_vector(near);
    }
  }
  EXPECT_LT((linear.tangent - tangent).norm(), 1e-6 * tangent.norm()) << linear.tangent << "\n" << tangent;
  EXPECT_LT((linear.sensitivity - sensitivity).norm(), 1e-6 * sensitivity.norm());

  // One factorization, 1e-16 times its condition number (1e3) at most.
  EXPECT_LT((linear.tangent - linear.tangent.transpose()).norm(), 1e-12 * linear.tangent.norm());
  // Asking along one direction only gives the product.
  const auto along = equilibrium.linearize(state, d);
  EXPECT_LT((along.tangent - linear.tangent * d).norm(), 1e-12 * along.tangent.norm());
  EXPECT_LT((along.sensitivity - linear.sensitivity * d).norm(), 1e-12 * along.sensitivity.norm());
}

INSTANTIATE_TEST_SUITE_P(Laws, CondensedTangent, ::testing::ValuesIn(every_case()), case_name);

}  // namespace
}  // namespace phynness::test
