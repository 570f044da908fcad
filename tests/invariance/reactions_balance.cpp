// Claim: under a tool, the forces at the held points (fixed and touched) sum to zero, and so do their moments about the
// origin: in the deformed configuration for the objective laws, in the reference configuration for the linear law,
// whose stress is symmetric there.
//
// Summed over all points both vanish up to rounding for any state, because shape functions sum to one and the energy is
// invariant to rigid motions: 1e-13 of the forces. Over the held points only, the difference is the residual at the
// free points: the solver's tolerance, 1e-10 of the reactions, times the square root of their number (about 1e2).
#include <gtest/gtest.h>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "solve/ray_solver.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

class Balance : public ::testing::TestWithParam<Case> {};

TEST_P(Balance, HeldPointsCarryNoNetForceAndNoNetMoment) {
  SolverSpec spec;
  spec.element = GetParam().element;
  spec.relative_tolerance = 1e-10;
  Random random(47);
  const auto mesh = irregular(block_mesh({4, 4, 3}, {1, 0.9, 0.7}), 0.05, random);
  Discretization body(mesh, form_set(unit_material(GetParam().law, 10), GetParam().element, 1));
  std::vector<std::int32_t> bottom;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (mesh.nodes(i, 2) == 0) bottom.push_back(i);
  const auto fixed = fixed_points(body, bottom);
  Equilibrium equilibrium(body, displacement_dofs(body, fixed), spec);
  const std::int32_t top = mesh.n_nodes() - 13;  // the middle of the upper face
  equilibrium.prescribe(tool_constraint(body, {at_node(top)}, 0.3, fixed));
  std::vector<char> touched(body.n_dofs(), 0);
  for (const auto* dofs : {&equilibrium.constraint().dofs, &equilibrium.constraint().masters})
    for (const auto dof : *dofs) touched[dof] = 1;
  RaySolver rays(body, equilibrium, spec);

  rays.follow(rays.rest(), Vector3(0.04, 0.03, -0.06), {0.5, 1}, false,
              [&](std::size_t, const PathStep& step, const PathPoint& point) {
                EXPECT_EQ(step.status, Status::converged);
                std::vector<double> r(body.n_dofs());
                body.residual(point.state, r);
                Vector3 force = Vector3::Zero(), moment = force, held_force = force, held_moment = force;
                double size = 0;
                for (int p = 0; p < body.n_points(); ++p) {
                  const Vector3 X = body.points().row(p).transpose();
                  const Vector3 x = GetParam().law->linear ? X : X + value_at(body, point.state, p);
                  const Vector3 f = value_at(body, r, p);
                  force += f;
                  moment += x.cross(f);
                  if (fixed[p] || touched[body.dofs(p)[0]]) {
                    held_force += f;
                    held_moment += x.cross(f);
                    size += f.norm();
                  }
                }
                EXPECT_GT(size, 0.05);
                EXPECT_LT(force.norm(), 1e-13 * size);
                EXPECT_LT(moment.norm(), 1e-13 * size);
                EXPECT_LT(held_force.norm(), 1e-8 * size);
                EXPECT_LT(held_moment.norm(), 1e-8 * size);
                return true;
              });
}

INSTANTIATE_TEST_SUITE_P(Laws, Balance, ::testing::ValuesIn(every_case()), case_name);

}  // namespace
}  // namespace phynness::test
