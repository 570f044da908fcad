// Claims: the fields of the linear predictor are those of the finite elements, at any depth for a linear law, and in
// the limit of small displacements with first order for a nonlinear law.
#include <gtest/gtest.h>

#include <cmath>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

ProbeBlock with_fields(const Case& c) {
  auto block = probe_block(c, 10, {2, 2, 2});
  block.scene.database.fields = {Field::von_mises_stress, Field::energy_density};
  return block;
}

/// Largest difference of a field of the predictor from the finite elements', over the largest value.
Eigen::Vector2d difference(ProbeSolver& solver, const Vec3& d) {
  const auto response = solver.solve({d}, 1);
  EXPECT_EQ(response.status, Status::converged);
  const auto linear = solver.linear_fields({d});
  Eigen::Vector2d largest;
  for (int f = 0; f < 2; ++f) {
    EXPECT_GT(response.fields.col(f).minCoeff(), -1e-12 * response.fields.col(f).maxCoeff());
    largest[f] = (linear.col(f) - response.fields.col(f)).cwiseAbs().maxCoeff() / response.fields.col(f).maxCoeff();
  }
  return largest;
}

class LinearFields : public ::testing::TestWithParam<Element> {};

TEST_P(LinearFields, AreExactWhereTheLawIsLinear) {
  const auto block = with_fields({law_named("linear"), GetParam()});
  auto solver = block.touched();
  // The solver's tolerance, 1e-8 of forces, is what remains.
  for (const Vec3& d : {Vec3{0.004, 0.002, -0.008}, Vec3{0, 0.03, 0.02}})
    EXPECT_LT(difference(solver, d).maxCoeff(), 1e-6);
}

TEST_P(LinearFields, AreTheLimitOfSmallDisplacements) {
  const auto block = with_fields({law_named("neo-hookean"), GetParam()});
  auto solver = block.touched();
  const auto far = difference(solver, {0.002, 0, -0.004}), near = difference(solver, {0.0002, 0, -0.0004});
  for (int f = 0; f < 2; ++f) {
    // A tenth of the displacement, a tenth of the error: 8 to 12 leaves room for the next order.
    EXPECT_GT(far[f] / near[f], 8) << name(every_field[static_cast<std::size_t>(f)]);
    EXPECT_LT(far[f] / near[f], 12) << name(every_field[static_cast<std::size_t>(f)]);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, LinearFields, ::testing::ValuesIn(every_element), element_name);

}  // namespace
}  // namespace phynness::test
