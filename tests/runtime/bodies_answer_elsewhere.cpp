// A body that knows what its modes lack at rest answers where no tool was probed.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <phynness/formats/body.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/phynness.hpp>
#include <vector>

#include "../block_body.hpp"
#include "loaded_body.hpp"

namespace phynness::test {
namespace {

/// A block of which only the part up to x = 60 mm was probed; beyond, from 90 mm on, its modes lack a compliance.
struct Part {
  explicit Part(bool knows) : text(text_of(block, knows)) {}
  static std::string text_of(Block& block, bool knows) {
    Eigen::MatrixXd lacking = Eigen::MatrixXd::Zero(block.mesh.n_nodes(), schema::n_of_root);
    for (Eigen::Index i = 0; i < lacking.rows(); ++i)
      if (block.mesh.nodes(i, 0) > 0.07) {
        block.body.kinds[static_cast<std::size_t>(i)] = schema::body_node_moves;
        lacking.row(i) << 0.1, 0.02, -0.01, 0.12, 0.01, 0.15;
      }
    if (knows) block.body.lacking = scaled_table(lacking);
    return write_body_text(block.body);
  }
  void rest() { body.rest(); }
  phn_tool tool(double x, const Eigen::Vector3d& displacement) const {
    return tool_at(nearest_on_surface(block.mesh.nodes, block.mesh.surface, {x, 0.062, 0.03}), displacement);
  }
  int press(const std::vector<phn_tool>& tools, int steps = 100) { return body.press(tools, steps); }
  Points field() const {
    const Eigen::VectorXd u = body.deformation();
    return Eigen::Map<const Points>(u.data(), u.size() / 3, 3);
  }

  Block block;
  std::string text;
  LoadedBody body{text};
  const std::array<Eigen::Vector3d, 3>& forces = body.force;
};

const Eigen::Vector3d inward(0.05 * block_depth, 0, -0.3 * block_depth);

// Claim: where tools were probed, all numbers are those without the table.
TEST(Elsewhere, ProbedPlacesKeepTheirBits) {
  Part knows(true), knows_not(false);
  for (const double x : {0.03, 0.041, 0.06}) {
    for (Part* part : {&knows, &knows_not})
      ASSERT_EQ(part->press({part->tool(x, inward), part->tool(0.06, inward)}) & ~PHN_WARNING_NEAR, 0);
    EXPECT_EQ(knows.forces[0], knows_not.forces[0]);
    EXPECT_EQ(knows.forces[1], knows_not.forces[1]);
    EXPECT_EQ(knows.body.pressed.energy, knows_not.body.pressed.energy);
    EXPECT_EQ(knows.field(), knows_not.field());
  }
}

// Claim: elsewhere the compliance of a tool alone at rest is that of the modes and what they lack, R R, and the warning
// says that it was not probed. What lacks moves the surface there.
TEST(Elsewhere, AToolHasTheComplianceOfBoth) {
  Part knows(true), knows_not(false);
  Eigen::Matrix3d compliance[2];
  constexpr double small = 1e-4 * block_depth;  // of the nonlinear response, this part is left
  for (int of = 0; of < 2; ++of) {
    Part& part = of == 0 ? knows : knows_not;
    for (Eigen::Index k = 0; k < 3; ++k) {
      part.rest();
      ASSERT_EQ(part.press({part.tool(0.1, small * Eigen::Vector3d::Unit(k))}), PHN_WARNING_OUTSIDE);
      compliance[of].col(k) = part.forces[0] / small;
    }
    compliance[of] = compliance[of].inverse().eval();
  }
  Eigen::Matrix3d root;
  root << 0.1, 0.02, -0.01, 0.02, 0.12, 0.01, -0.01, 0.01, 0.15;
  const Eigen::Matrix3d lacking = root * root;
  EXPECT_LT((compliance[0] - compliance[1] - lacking).norm(), 2e-3 * lacking.norm());
  ASSERT_EQ(knows.press({knows.tool(0.12, inward)}), PHN_WARNING_OUTSIDE);
  const Eigen::Vector3d added = lacking * knows.forces[0];
  EXPECT_GT(added.norm(), 0.1 * inward.norm());
  const Eigen::Vector3d force = knows.forces[0];
  ASSERT_EQ(knows_not.press({knows_not.tool(0.12, inward - added)}), PHN_WARNING_OUTSIDE);
  EXPECT_LT((knows_not.forces[0] - force).norm(), 1e-4 * force.norm());
  const Points more = knows.field() - knows_not.field();
  for (Eigen::Index i = 0; i < more.rows(); ++i) {
    EXPECT_LE(more.row(i).norm(), 1.001 * added.norm());
    if (knows.block.mesh.nodes(i, 0) < 0.07) {
      EXPECT_LT(more.row(i).norm(), 1e-4 * added.norm());
    }
  }
  EXPECT_GT(more.rowwise().norm().maxCoeff(), 0.9 * added.norm());
}

// Claim: forces of tools on either side are the derivatives of the energy; two with one displacement at one place share
// the force of one, up to what is not linear; opposed ones have at most a few times that of each alone.
TEST(Elsewhere, SeveralToolsHaveAnEnergy) {
  Part part(true);
  const Eigen::Vector3d b(-0.1 * block_depth, 0, -0.2 * block_depth);
  for (const double other : {0.04, 0.1, 0.112})
    expect_forces_of_an_energy(
        part.body, {inward, b}, 1e-3 * block_depth,
        [&](const auto& x, const auto& y) {
          return part.press({part.tool(0.1, x), part.tool(other, y)});
        },
        other);
  part.rest();
  ASSERT_EQ(part.press({part.tool(0.1, inward)}), PHN_WARNING_OUTSIDE);
  const Eigen::Vector3d alone = part.forces[0];
  ASSERT_EQ(part.press({part.tool(0.1, inward), part.tool(0.1, inward)}), PHN_WARNING_OUTSIDE | PHN_WARNING_NEAR);
  EXPECT_LT((part.forces[0] - alone / 2).norm(), 1e-3 * alone.norm());
  ASSERT_EQ(part.press({part.tool(0.1, inward), part.tool(0.1, -inward)}), PHN_WARNING_OUTSIDE | PHN_WARNING_NEAR);
  EXPECT_LT(part.forces[0].norm(), 6 * alone.norm());
}

// Claim: a tool and a sphere that slide over the border of the probed part at 100 mm/s, one step in each millisecond,
// have forces that change by at most 1 % of the largest from one to the next.
TEST(Elsewhere, SlidesCrossTheBorder) {
  constexpr double step = 1e-4, from = 0.03, to = 0.115, depth = 0.3 * block_depth;
  Part part(true);
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  double largest = 0, change = 0;
  ASSERT_GE(part.press({part.tool(from, inward)}), 0);
  for (double x = from; x < to; x += step) {
    ASSERT_GE(part.press({part.tool(x, inward)}, 1), 0);
    if (x > from) change = std::max(change, (part.forces[0] - last).norm());
    last = part.forces[0];
    largest = std::max(largest, last.norm());
  }
  EXPECT_LT(change, 0.01 * largest);

  constexpr double radius = 0.01;
  for (const bool knows : {true, false}) {
    Organ organ({}, Part(knows).text);
    ASSERT_TRUE(organ);
    const auto touch = [&](double x, double deep) {
      const phn_contact_tool sphere{{x, 0.062, 0.03 + radius - deep}, radius, 0, PHN_TOOL_PRESS};
      phn_contact_state state{};
      EXPECT_GE(organ.touch({&sphere, 1}, {&state, 1}), 0);
      return Eigen::Vector3d(state.force);
    };
    largest = change = 0;
    for (double deep = -0.001; deep < depth; deep += step) touch(from, deep);
    last = touch(from, depth);
    for (double x = from; x < to; x += step) {
      const Eigen::Vector3d force = touch(x, depth);
      change = std::max(change, (force - last).norm());
      largest = std::max(largest, force.norm());
      last = force;
    }
    if (knows) {
      EXPECT_LT(change, 0.01 * largest);
      EXPECT_GT(last.norm(), 0.02 * largest);
    } else {
      EXPECT_EQ(last.norm(), 0) << "what moves the surface is not touched without the table";
    }
  }
}

// Claim: the nearest place that can be touched is beyond the border only where it answers.
TEST(Elsewhere, PlacesAreFound) {
  const double x[] = {0.1, 0.062, 0.04};
  for (const bool knows : {true, false}) {
    const Part part(knows);
    phn_tool tool;
    double point[3];
    ASSERT_EQ(phn_body_nearest(part.body.body, x, &tool, point, nullptr), PHN_OK);
    EXPECT_EQ(std::abs(point[0] - 0.1) < 1e-9, knows) << point[0];
  }
}

}  // namespace
}  // namespace phynness::test
