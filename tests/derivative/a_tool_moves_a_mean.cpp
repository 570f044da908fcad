// Claims: a round tool moves a weighted mean of the surface by d, with forces w_i F on its points and none elsewhere;
// the weights are the normalized integrals of an even pressure times the element's functions; fixed points have none;
// two tools may share points. The path goes on where the force has a maximum, at which the free body is singular.
#include <gtest/gtest.h>

#include <phynness/formats/error.hpp>
#include <phynness/meshes/tool_weights.hpp>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "messages.hpp"
#include "solve/ray_solver.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

const Law neo_hookean = law_named("neo-hookean");

/// Weights of the points that one tool moves, from its constraint: x_h = q / w_h - sum_j (w_j / w_h) x_j.
std::map<std::int32_t, double> weights_of(const Constraint& constraint) {
  std::map<std::int32_t, double> weight;
  weight[constraint.dofs[0]] = 1 / constraint.G(0, 0);
  for (std::size_t j = 0; j < constraint.masters.size(); j += 3)
    weight[constraint.masters[j]] = -constraint.M(0, static_cast<Eigen::Index>(j)) / constraint.G(0, 0);
  return weight;
}

class RoundTool : public ::testing::TestWithParam<Element> {};

TEST_P(RoundTool, HasTheMomentsOfAnEvenPressure) {
  // A plane surface. The functions of linear elements reproduce linear polynomials, so that sum w_i x_i is the middle
  // of the tool; those of quadratic elements reproduce squares, whose mean over the pressure is 1/2 R^2 in both
  // directions together. The rim is resolved to 0.004 R; measured: 2e-5 R.
  auto mesh = block_mesh({6, 6, 2}, {1.2, 1.2, 0.5});
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) {
    mesh.nodes(i, 0) += 0.06 * std::sin(7 * mesh.nodes(i, 1));
    mesh.nodes(i, 1) += 0.05 * std::sin(6 * mesh.nodes(i, 0));
  }
  Discretization body(mesh, form_set(unit_material(neo_hookean, 10), GetParam(), 1));
  const double R = 0.33;
  const auto center = nearest_on_surface(mesh.nodes, mesh.surface, {0.57, 0.64, 0.5});
  const auto constraint = tool_constraint(body, {center}, R, std::vector<char>(body.n_points(), 0));
  const auto weight = weights_of(constraint);
  double sum = 0, square = 0;
  Vector3 mean = Vector3::Zero();
  for (int p = 0; p < body.n_points(); ++p)
    if (const auto w = weight.find(body.dofs(p)[0]); w != weight.end()) {
      const Vector3 x = body.points().row(p).transpose() - Eigen::RowVector3d(0.57, 0.64, 0.5).transpose();
      sum += w->second;
      mean += w->second * x;
      square += w->second * x.squaredNorm();
    }
  EXPECT_GT(weight.size(), 8u);
  EXPECT_NEAR(sum, 1, 1e-12);
  EXPECT_LT(mean.norm(), 1e-4 * R);
  if (GetParam()->displacement_degree == 2) {
    EXPECT_NEAR(square, 0.5 * R * R, 1e-4 * R * R);
  }
}

TEST_P(RoundTool, MovesItsMeanByForcesInProportionToTheWeights) {
  SolverSpec spec;
  spec.element = GetParam();
  spec.relative_tolerance = 1e-11;
  const auto mesh = block_mesh({4, 4, 3}, {1, 1, 0.8});
  Discretization body(mesh, form_set(unit_material(neo_hookean, 10), GetParam(), 1));
  std::vector<std::int32_t> held;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (mesh.nodes(i, 2) == 0 || mesh.nodes(i, 0) == 0) held.push_back(i);
  const auto fixed = fixed_points(body, held);
  Equilibrium equilibrium(body, displacement_dofs(body, fixed), spec);
  // Two tools that overlap; the first reaches the fixed side.
  const std::vector<SurfacePoint> places{nearest_on_surface(mesh.nodes, mesh.surface, {0.21, 0.5, 0.8}),
                                         nearest_on_surface(mesh.nodes, mesh.surface, {0.52, 0.45, 0.8})};
  std::vector<std::map<std::int32_t, double>> weights;
  for (const auto& place : places) weights.push_back(weights_of(tool_constraint(body, {place}, 0.3, fixed)));
  for (const auto dof : displacement_dofs(body, fixed)) EXPECT_EQ(weights[0].count(dof), 0u);
  equilibrium.prescribe(tool_constraint(body, places, 0.3, fixed));
  RaySolver rays(body, equilibrium, spec);
  Eigen::VectorXd d(6);
  d << 0.02, 0.01, -0.04, 0.01, -0.02, -0.06;
  rays.follow(rays.rest(), d, {0.5, 1.0}, false, [&](std::size_t, const PathStep& step, const PathPoint& point) {
    EXPECT_EQ(step.status, Status::converged);
    std::vector<double> r(body.n_dofs());
    body.residual(point.state, r);
    for (int p = 0; p < body.n_points(); ++p)
      for (std::size_t t = 0; t < 2 && !fixed[p]; ++t)
        if (const auto w = weights[t].find(body.dofs(p)[0]); w != weights[t].end())
          for (int k = 0; k < 3; ++k) r[body.dofs(p)[k]] -= w->second * point.force[3 * static_cast<int>(t) + k];
    double left = 0;
    for (int p = 0; p < body.n_points(); ++p)
      for (int k = 0; k < 3 && !fixed[p]; ++k) left = std::max(left, std::abs(r[body.dofs(p)[k]]));
    EXPECT_LT(left, 1e-9 * point.force.norm());
    for (std::size_t t = 0; t < 2; ++t)
      for (int k = 0; k < 3; ++k) {
        double mean = 0;
        for (int p = 0; p < body.n_points(); ++p)
          if (const auto w = weights[t].find(body.dofs(p)[0]); w != weights[t].end())
            mean += w->second * point.state[body.dofs(p)[k]];
        EXPECT_NEAR(mean, point.s * d[3 * static_cast<int>(t) + k], 1e-13);
      }
    return true;
  });
}

TEST_P(RoundTool, GoesOnBeyondAMaximumOfTheForce) {
  // A shallow arch of rise 1 between clamped ends snaps through: the force on its middle has a maximum and a minimum.
  SolverSpec spec;
  spec.element = GetParam();
  const bool quadratic = GetParam()->displacement_degree == 2;
  auto mesh = block_mesh({quadratic ? 12 : 40, 1, quadratic ? 1 : 3}, {10, 1, 0.4});
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) {
    const double s = mesh.nodes(i, 0) / 10;
    mesh.nodes(i, 2) += 4 * s * (1 - s);
  }
  Discretization body(mesh, form_set(unit_material(neo_hookean, 2), GetParam(), 1));
  std::vector<std::int32_t> ends;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i)
    if (mesh.nodes(i, 0) == 0 || mesh.nodes(i, 0) == 10) ends.push_back(i);
  const auto fixed = fixed_points(body, ends);
  Equilibrium equilibrium(body, displacement_dofs(body, fixed), spec);
  equilibrium.prescribe(
      tool_constraint(body, {nearest_on_surface(mesh.nodes, mesh.surface, {5.1, 0.45, 1.4})}, 0.8, fixed));
  RaySolver rays(body, equilibrium, spec);
  std::vector<double> depths, force;
  for (int i = 1; i <= 32; ++i) depths.push_back(2.4 * i / 32);
  rays.follow(rays.rest(), Vector3(0, 0, -1), depths, false,
              [&](std::size_t i, const PathStep& step, const PathPoint& point) {
                EXPECT_EQ(step.status, Status::converged) << "depth " << depths[i];
                force.push_back(-point.force[2]);
                return step.status == Status::converged;
              });
  ASSERT_EQ(force.size(), depths.size());
  const auto top = std::max_element(force.begin(), force.begin() + 16);
  const auto bottom = std::min_element(top, force.end());
  std::printf("%s: force %.4g at depth %.3g, then %.4g at %.3g, %.4g at the end\n", name(GetParam()), *top,
              depths[top - force.begin()], *bottom, depths[bottom - force.begin()], force.back());
  EXPECT_LT(*bottom, 0.9 * *top);
  EXPECT_GT(force.back(), 1.5 * *top);
}

INSTANTIATE_TEST_SUITE_P(Elements, RoundTool, ::testing::ValuesIn(every_element), element_name);

TEST(Tools, AtOnePlaceAreRefused) {
  const auto mesh = block_mesh({4, 4, 3}, {1, 1, 0.8});
  const Discretization body(mesh, form_set(unit_material(neo_hookean, 10), element_named("P1"), 1));
  const auto place = nearest_on_surface(mesh.nodes, mesh.surface, {0.5, 0.5, 0.8});
  const std::vector<char> fixed(body.n_points(), 0), all(body.n_points(), 1);
  for (const double radius : {0.0, 0.3}) {
    expect_names(message_of([&] { tool_constraint(body, {place, place}, radius, fixed); }), {"same place"});
    expect_names(message_of([&] { tool_constraint(body, {place}, radius, all); }), {"all nodes of a tool are fixed"});
  }
}

}  // namespace
}  // namespace phynness::test
