// Claim: a body that misses its target loses its tables at rest if it is better without them by a tenth; any other body
// remains as it is, bit by bit. The body here is a block of linear elements whose tables, where it has them, multiply
// the energy of its shape by 1.3.
#include <gtest/gtest.h>

#include <phynness/formats/body.hpp>
#include <phynness/validation/several_tools.hpp>

#include "../block_body.hpp"
#include "loaded_body.hpp"

namespace phynness::test {
namespace {

/// States of two tools with the forces of a body.
std::vector<SolvedTools> solved_by(const ReducedBody& body) {
  LoadedBody loaded(write_body_text(body));
  std::vector<SolvedTools> states;
  for (const double scale : {0.3, 0.6, 1.0}) {
    SolvedTools state;
    const auto tool = [&](double x, Eigen::Vector3d d) {
      std::int32_t node = 0;
      (body.points.rowwise() - Eigen::RowVector3d(x, 0.06, 0.03)).rowwise().norm().minCoeff(&node);
      d *= scale * block_depth;
      state.tools.push_back(phn_tool_at(node, d.data()));
    };
    tool(0.06, {0.2, 0.1, -0.6});
    tool(0.12, {-0.3, 0.2, 0.4});
    EXPECT_EQ(loaded.press(state.tools), PHN_OK);
    for (const std::size_t t : {0, 1})
      state.force_N.push_back({loaded.force[t][0], loaded.force[t][1], loaded.force[t][2]});
    states.push_back(state);
  }
  return states;
}

TEST(TablesAtRest, AreLeftOutOfBodiesThatAreBetterWithoutThem) {
  const Block block;
  const auto n = block.body.modes.entries.cols();
  ReducedBody with = block.body;
  // Newton's method has 0.3e-6 J more on its diagonal, which is small beside the stiffness.
  with.cells_at_rest = scaled_table(1e-6 * Eigen::MatrixXd::Identity(n, n));
  with.lack_at_rest = scaled_table(0.3e-6 * Eigen::MatrixXd::Identity(n, n));
  const auto wanted = solved_by(block.body), wanted_with = solved_by(with);
  ReducedBody body = with;
  auto errors = tool_errors(body, wanted);
  const double error = target_error(errors, 2);
  EXPECT_GT(error, 0.05);
  EXPECT_LT(error, 2.5 * 0.3);                                      // forces are at most 1.3 times those wanted
  EXPECT_FALSE(leave_out_at_rest(body, errors, wanted, error, 2));  // which is what is wanted
  EXPECT_EQ(write_body_text(body), write_body_text(with));
  EXPECT_TRUE(leave_out_at_rest(body, errors, wanted, 0.99 * error, 2));
  EXPECT_EQ(write_body_text(body), write_body_text(block.body));
  EXPECT_LT(errors.pairs.max, 1e-3);                            // the steps of Newton's method end there
  EXPECT_FALSE(leave_out_at_rest(body, errors, wanted, 0, 2));  // none are left
  body = with;
  errors = tool_errors(body, wanted_with);
  EXPECT_LT(errors.pairs.max, 1e-3);
  EXPECT_FALSE(leave_out_at_rest(body, errors, wanted_with, 0, 2));
  EXPECT_EQ(write_body_text(body), write_body_text(with));
  EXPECT_LT(errors.pairs.max, 1e-3);
}

// Claim: the displacements under tools are those of a body that has come from rest to half of their way, and to its
// end.
TEST(TablesAtRest, DisplacementsAreThoseUnderTheTools) {
  const Block block;
  auto states = solved_by(block.body);
  states.erase(states.begin());
  const auto found = displacements_under(block.body, states);
  ASSERT_EQ(found.cols(), 4);
  for (Eigen::Index s = 0; s < 2; ++s) {
    LoadedBody loaded(write_body_text(block.body));
    for (int quarter = 1; quarter <= 4; ++quarter) {
      auto tools = states[static_cast<std::size_t>(s)].tools;
      for (auto& tool : tools)
        for (auto& d : tool.displacement) d *= quarter / 4.0;
      loaded.press(tools);
      if (quarter % 2 == 0) {  // steps of Newton's method end below a nanometre
        EXPECT_LT((found.col(2 * s + quarter / 2 - 1) - loaded.deformation()).cwiseAbs().maxCoeff(), 1e-9);
      }
    }
    EXPECT_GT(found.col(2 * s).norm(), 0.2 * found.col(2 * s + 1).norm());
  }
}

// Claim: a target is missed by p95 of two tools, by a maximum of three times the target, by a mean above 0.4 of it, and
// in a scene of three tools by p95 of three above twice the target.
TEST(TablesAtRest, AreJudgedByTheTarget) {
  ToolErrors errors;
  errors.pairs.p95 = 0.1;
  errors.pairs.max = 0.24;
  errors.triples.p95 = 0.5;
  EXPECT_EQ(target_error(errors, 2), 0.1);
  EXPECT_EQ(target_error(errors, 3), 0.25);
  errors.pairs.max = 0.9;
  EXPECT_NEAR(target_error(errors, 3), 0.3, 1e-15);
  errors.pairs.mean = 0.2;
  EXPECT_NEAR(target_error(errors, 3), 0.5, 1e-15);
}

}  // namespace
}  // namespace phynness::test
