// Claims about the points of the surface that were not probed: they answer as the body at rest, and change nothing
// where all was probed.
#include <gtest/gtest.h>

#include <cmath>

#include "loaded_model.hpp"
#include "round_models.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Nodes 3, 5 and 8 have round tools, between which node 12 is covered.
Model probed_part(Family family) {
  Model model = covered_model_of(family);
  model.nodes.pop_back();
  return model;
}

struct Answer {
  int status = 0, depth_status = 0, bound_status = 0;
  Eigen::Vector3d force;
  double energy = 0, depth = 0, bound = 0;
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
  Points field = Points::Zero(12, 3);
};

class LinearPoints : public testing::TestWithParam<Family> {
 protected:
  const Model part = probed_part(GetParam()), whole = with_linear_points(part);
  const LoadedModel of_part{write_model_text(part)}, of_whole{write_model_text(whole)};
  const bool has_energy = GetParam() != Family::rbfn, proportional = GetParam() == Family::linear;
  const int outside = proportional ? PHN_OK : PHN_WARNING_OUTSIDE;

  Answer at(const LoadedModel& in, phn_tool tool, const Eigen::Vector3d& d) const {
    Answer a;
    for (int k = 0; k < 3; ++k) tool.displacement[k] = d[k];
    a.status = phn_force(in.model, in.data, &tool, a.force.data(), has_energy ? &a.energy : nullptr,
                         has_energy ? a.stiffness.data() : nullptr);
    a.depth_status = phn_depth(in.model, &tool, &a.depth);
    a.bound_status = phn_bound(in.model, &tool, &a.bound);
    EXPECT_EQ(phn_deform(in.model, in.data, &tool, a.field.data()), a.status);
    return a;
  }
};
INSTANTIATE_TEST_SUITE_P(Families, LinearPoints, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

const Eigen::Vector3d pressed(0.003, -0.002, 0.004);

phn_tool place_at(std::int32_t a, std::int32_t b, std::int32_t c, double first, double second) {
  return {{a, b, c}, {first, second, 1 - first - second}, {0, 0, 0}, {0, 0}};
}

// Claim: at a linear point the force is K d, the energy d . K d / 2, the field the sum of the modes that it mixes, or
// its own near values; all of it is outside of the trained range, but in a linear body. Modes are floats: 1e-6.
TEST_P(LinearPoints, AnswerAsTheBodyAtRest) {
  for (const LinearPoint& point : whole.linear_points) {
    const Answer said = at(of_whole, place_at(point.node, -1, -1, 1, 0), pressed);
    EXPECT_EQ(said.status, outside);
    EXPECT_EQ(said.depth_status, outside);
    EXPECT_EQ(said.depth, 0);
    EXPECT_EQ(said.bound_status, proportional ? PHN_ERROR_UNDEFINED : PHN_WARNING_OUTSIDE);
    EXPECT_EQ(said.bound, PHN_NO_BOUND);
    EXPECT_LT((said.force - point.stiffness * pressed).norm(), 1e-14 * said.force.norm());
    if (has_energy) {
      EXPECT_NEAR(said.energy, pressed.dot(point.stiffness * pressed) / 2, 1e-14 * std::abs(said.energy));
      EXPECT_EQ(said.stiffness, point.stiffness);
    }
    Eigen::MatrixXd unit = whole.rest_modes.values() * point.mixing.values();
    const Eigen::MatrixXd near = point.near_modes.values();
    for (std::size_t i = 0; i < point.near.size(); ++i)
      unit.middleRows<3>(3 * point.near[i]) = near.middleRows<3>(3 * static_cast<Eigen::Index>(i));
    const Eigen::VectorXd u = unit * pressed;
    EXPECT_LT((said.field - Eigen::Map<const Points>(u.data(), 12, 3)).cwiseAbs().maxCoeff(),
              1e-6 * said.field.cwiseAbs().maxCoeff());
  }
}

// Claim: at probed nodes and wherever all corners were probed, every answer has the bits of the model without linear
// points, at every level.
TEST_P(LinearPoints, ChangeNothingThatWasProbed) {
  const phn_tool places[] = {place_at(3, -1, -1, 1, 0),   place_at(8, -1, -1, 1, 0),    place_at(12, -1, -1, 1, 0),
                             place_at(3, 5, 8, 0.5, 0.3), place_at(8, 5, 12, 0.2, 0.5), place_at(5, 3, 0, 0.45, 0.45)};
  for (const phn_tool& tool : places) {
    const Answer before = at(of_part, tool, pressed), after = at(of_whole, tool, pressed);
    EXPECT_EQ(before.status, after.status);
    EXPECT_EQ(before.force, after.force);
    EXPECT_EQ(before.energy, after.energy);
    EXPECT_EQ(before.stiffness, after.stiffness);
    EXPECT_EQ(before.depth, after.depth);
    EXPECT_EQ(before.bound, after.bound);
    EXPECT_EQ(before.field, after.field);
  }
}

// Claim: between probed and linear points the answer is the mean of both, so that it is continuous; its warning begins
// where a linear point has more than 1e-5 of the weight. A corner with less brings no warning either way.
TEST_P(LinearPoints, JoinThoseThatWereProbed) {
  const Answer probed = at(of_whole, place_at(3, -1, -1, 1, 0), pressed),
               linear = at(of_whole, place_at(11, -1, -1, 1, 0), pressed);
  for (const double share : {0.0, 1e-6, 0.25, 0.5, 1 - 1e-6, 1.0}) {
    const Answer said = at(of_whole, place_at(11, 3, -1, share, 1 - share), pressed);
    // The gradient at node 3 is that between probed nodes, and linear points have their own.
    EXPECT_LT((said.force - share * linear.force - (1 - share) * probed.force).norm(),
              2 * share * (1 - share) * (probed.force.norm() + linear.force.norm()) + 1e-12);
    EXPECT_EQ(said.status, share > 1e-5 ? outside | (share < 1 - 1e-5 ? probed.status : 0) : probed.status) << share;
    EXPECT_EQ(said.depth == 0, share > 1e-5);
  }
}

// Claim: the force changes continuously on a slide from a probed point to a linear one, also over a covered node
// between them: in a thousandth of an edge by no more than a few thousandths, for gradients enter with products of
// weights.
TEST_P(LinearPoints, SlideWithoutAJump) {
  for (const auto& [from, to] : {std::pair(3, 10), std::pair(10, 11), std::pair(5, 11), std::pair(12, 13)}) {
    const auto force_at = [&, from = from, to = to](double share) {
      return at(of_whole, place_at(to, from, -1, share, 1 - share), pressed).force;
    };
    Eigen::Vector3d last = force_at(0);
    for (int i = 1; i <= 1000; ++i) {
      const Eigen::Vector3d next = force_at(i / 1000.0);
      EXPECT_LT((next - last).norm(), 5e-3 * (force_at(0).norm() + force_at(1).norm())) << from << " " << i;
      last = next;
    }
  }
}

// Claim: forces are gradients of the energy there, too. Central differences over 1e-6 m leave 1e-7.
TEST_P(LinearPoints, HaveForcesThatAreGradients) {
  if (!has_energy) return;
  for (const phn_tool& tool : {place_at(10, 11, 13, 0.3, 0.3), place_at(3, 11, 10, 0.4, 0.2)}) {
    const Answer here = at(of_whole, tool, pressed);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
      const Answer more = at(of_whole, tool, pressed + step), less = at(of_whole, tool, pressed - step);
      EXPECT_NEAR((more.energy - less.energy) / 2e-6, here.force[k], 1e-7 * here.force.norm());
      EXPECT_LT(((more.force - less.force) / 2e-6 - here.stiffness.col(k)).norm(), 1e-6 * here.stiffness.norm());
    }
    EXPECT_EQ(at(of_whole, tool, Eigen::Vector3d::Zero()).energy, 0);
  }
}

// Claim: node 5 stopped short in one direction; along an edge beside it no weight of the size of a float's rounding
// brings the warning.
TEST_P(LinearPoints, TinyCornersDoNotWarn) {
  for (const double tiny : {0.0, 1e-17, 1e-12, 9e-6})
    EXPECT_EQ(at(of_whole, place_at(3, 8, 5, 0.5, 0.5 - tiny), pressed).status, PHN_OK) << tiny;
  EXPECT_EQ(at(of_whole, place_at(3, 8, 5, 0.5, 0.5 - 2e-5), pressed).status, PHN_WARNING_INCOMPLETE);
}

// Claim: a model of several levels has the linear points at each, and the text of a model is exact.
TEST(LinearPointsOfLevels, AreAtEachLevel) {
  const Model model = with_linear_points(with_levels(probed_part(Family::modal)));
  const std::string text = write_model_text(model);
  EXPECT_EQ(write_model_text(read_model_text(text, "model.txt")), text);
  const LoadedModel loaded(text);
  for (std::int32_t level = 0; level < 3; ++level) {
    ASSERT_EQ(phn_set_level(loaded.model, loaded.data, level), PHN_OK);
    const phn_tool tool = {{13, -1, -1}, {1, 0, 0}, {pressed[0], pressed[1], pressed[2]}, {0, 0}};
    Eigen::Vector3d force;
    EXPECT_EQ(phn_force(loaded.model, loaded.data, &tool, force.data(), nullptr, nullptr), PHN_WARNING_OUTSIDE);
    EXPECT_LT((force - model.linear_points[1].stiffness * pressed).norm(), 1e-14 * force.norm());
  }
}

}  // namespace
