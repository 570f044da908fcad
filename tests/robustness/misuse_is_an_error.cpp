// Claim: input that cannot be solved is refused with a message that names the value and the remedy, before any result
// is computed.
#include <gtest/gtest.h>

#include "messages.hpp"
#include "probe_block.hpp"

namespace phynness::test {
namespace {

class Touch : public ::testing::Test {
 protected:
  ProbeBlock _block = probe_block({law_named("neo-hookean"), element_named("P1")}, 10, {4, 4, 3});
  ProbeSolver _solver = _block.solver();

  std::string refusal(const std::vector<std::int32_t>& nodes) {
    return message_of([&] { _solver.touch(nodes); });
  }
};

TEST_F(Touch, OfANodeThatDoesNotExist) {
  expect_names(refusal({_block.mesh.n_nodes()}), {"node " + std::to_string(_block.mesh.n_nodes())});
  expect_names(refusal({-1}), {"node -1"});
}

TEST_F(Touch, OfAnInteriorNode) {
  const auto interior = *interior_nodes(_block.mesh).begin();
  const auto text = refusal({interior});
  expect_names(text, {"inside"});
  expect_names(text, {"node " + std::to_string(interior)});
}

TEST_F(Touch, OfAFixedNode) { expect_names(refusal({_block.sets.fixed[3]}), {"fixed"}); }

TEST_F(Touch, OfTheSameNodeTwice) { expect_names(refusal({_block.top, _block.top}), {"same place"}); }

TEST_F(Touch, IsPossibleAfterARefusal) {
  refusal({-1});
  _solver.touch({_block.top});
  EXPECT_EQ(_solver.solve({{0, 0, -0.002}}, 1).status, Status::converged);
}

class Supports : public ::testing::TestWithParam<Element> {
 protected:
  static ProbeBlock fixed_at(const std::vector<std::int32_t>& nodes) {
    auto block = probe_block({law_named("neo-hookean"), GetParam()}, 10, {4, 4, 3});
    block.sets.fixed = nodes;
    return block;
  }
};

TEST_P(Supports, ThatLeaveARigidMotionAreRefused) {
  // Nodes 0 to 4 lie on an edge. A factorization would go through: rounding turns its zero pivots into small
  // numbers, and the forces that come out look like any others.
  for (const auto& nodes : std::vector<std::vector<std::int32_t>>{{}, {2}, {0, 4}, {0, 1, 2, 3, 4}})
    expect_names(message_of([&] { fixed_at(nodes).touched(); }),
                 {"do not hold the body: " + std::to_string(nodes.size())});
}

TEST_P(Supports, OfThreeNodesOffOneLineAreEnough) {
  auto solver = fixed_at({0, 4, 20}).touched();
  const auto& k = solver.rest().stiffness_N_per_m;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(k);
  EXPECT_GT(eigen.eigenvalues()[0], 0.1 * eigen.eigenvalues()[2]) << k;
}

INSTANTIATE_TEST_SUITE_P(Elements, Supports, ::testing::ValuesIn(every_element), element_name);

}  // namespace
}  // namespace phynness::test
