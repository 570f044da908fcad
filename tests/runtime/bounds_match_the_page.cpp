// Claim: the bound of the force's error is that of formats/model.md: linear between the displacements of the nearest
// direction, at rest the size of the force there, none outside of the trained range; a model without bounds says that
// it has none. A refused call has none either: 0 would say that the force is exact. The error of the force at rest is
// within its bound in every family.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "linear_body.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// The page, with no regard to speed.
double bound_of(const Model& model, const ActiveNodeModel& node, const Eigen::Vector3d& d, double at_rest) {
  Eigen::Index nearest = 0;
  double best = -2;
  for (std::size_t k = 0; k < model.directions.size(); ++k) {
    const auto& e = model.directions[k];
    const double along = d.dot(Eigen::Vector3d(e[0], e[1], e[2])) / d.norm();
    if (along > best) {
      best = along;
      nearest = static_cast<Eigen::Index>(k);
    }
  }
  const Eigen::Index n = model.displacements.rows() / static_cast<Eigen::Index>(model.directions.size());
  const Eigen::MatrixXd values = node.bounds[0].values().cwiseMax(0);
  double before = 0, value = at_rest;
  for (Eigen::Index j = 0; j < n; ++j) {
    const double length = model.displacements.row(nearest * n + j).norm(), next = values(nearest * n + j, 0);
    if (d.norm() <= length) return value + (next - value) * (d.norm() - before) / (length - before);
    before = length;
    value = next;
  }
  return value;
}

double size_at_rest(const LoadedModel& loaded, std::int32_t node) {
  const Eigen::Vector3d rest(0, 0, 0);
  Eigen::Vector3d force;
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(node, rest.data()), force.data(), nullptr, nullptr) < 0, false);
  return force.norm();
}

class Bounds : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Bounds, testing::Values(Family::rbfn, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Bounds, AreThoseOfThePage) {
  for (const bool leveled : {false, true}) {
    const Model plain = small_model_of(GetParam()), model = with_bounds(leveled ? with_levels(plain) : plain);
    const LoadedModel loaded(write_model_text(model));
    Numbers numbers;
    int inside = 0, positive = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d d = 0.009 * numbers.vector();
      for (const auto& node : model.nodes) {
        double bound = -1;
        const int status = phn_bound(loaded.model, AtNode(node.node, d.data()), &bound);
        Eigen::Vector3d force;
        EXPECT_EQ(status,
                  phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force.data(), nullptr, nullptr));
        if ((status & PHN_WARNING_OUTSIDE) != 0) {
          EXPECT_EQ(bound, PHN_NO_BOUND);
          continue;
        }
        ++inside;
        positive += bound > 0 ? 1 : 0;
        // 1e-14 of the largest bound, 0.02, or of the largest force at rest: rounding.
        const double at_rest = size_at_rest(loaded, node.node);
        EXPECT_NEAR(bound, bound_of(model, node, d, at_rest), 2e-16 + 1e-14 * at_rest);
      }
    }
    EXPECT_GT(inside, 1000);
    EXPECT_GT(positive, 500);
  }
}

class Rest : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Rest, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

TEST_P(Rest, IsWithinTheBound) {
  const double rest[] = {0, 0, 0};
  const bool linear = GetParam() == Family::linear;
  const Model model = linear ? small_model_of(GetParam()) : with_bounds(small_model_of(GetParam()));
  const LoadedModel loaded(write_model_text(model));
  for (const auto& node : model.nodes) {
    const double error = size_at_rest(loaded, node.node);
    double bound = -1;
    // A family that is exact at any depth has no bounds.
    EXPECT_EQ(phn_bound(loaded.model, AtNode(node.node, rest), &bound) < 0, linear);
    EXPECT_EQ(bound == PHN_NO_BOUND, linear);
    EXPECT_LE(error, bound);
    // 1e-14: the bound is rounded up.
    if (!linear) {
      EXPECT_LE(bound, error * (1 + 1e-14));
    }
    EXPECT_EQ(error > 0, GetParam() == Family::rbfn);
  }
}

TEST_P(Bounds, AreKnownOnlyWhereTheyAreStored) {
  const double rest[] = {0, 0, 0}, far[] = {1, 0, 0}, nan = std::numeric_limits<double>::quiet_NaN(),
               no[] = {nan, 0, 0};
  const LoadedModel loaded(write_model_text(with_bounds(small_model_of(GetParam()))));
  const LoadedModel without(write_model_text(small_model_of(GetParam())));
  double bound = -1;
  EXPECT_EQ(phn_bound(loaded.model, AtNode(3, far), &bound), PHN_WARNING_OUTSIDE);
  EXPECT_EQ(bound, PHN_NO_BOUND);
  const auto refused = [&](int status, int expected) {
    EXPECT_EQ(status, expected);
    EXPECT_EQ(bound, PHN_NO_BOUND);
    bound = -1;
  };
  refused(phn_bound(without.model, AtNode(3, rest), &bound), PHN_ERROR_UNDEFINED);
  refused(phn_bound(loaded.model, AtNode(4, rest), &bound), PHN_ERROR_NOT_ACTIVE);
  refused(phn_bound(loaded.model, AtNode(3, no), &bound), PHN_ERROR_NOT_FINITE);
  refused(phn_bound(nullptr, AtNode(3, rest), &bound), PHN_ERROR_ARGUMENT);
  refused(phn_bound(loaded.model, AtNode(3, nullptr), &bound), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_bound(loaded.model, AtNode(3, rest), nullptr), PHN_ERROR_ARGUMENT);
}

// Claim: one tool between nodes has the bound of the page, at every level. 1e-9: rounding of forces.
TEST(BoundBetween, IsThatOfThePage) {
  const Model model = with_bound_between(bent(LinearBody(7, false)));
  const LoadedModel loaded(write_model_text(model));
  const auto at_node = [&](std::int32_t node, const Eigen::Vector3d& d) {
    double bound = 0;
    Eigen::Vector3d force;
    EXPECT_GE(phn_bound(loaded.model, AtNode(node, d.data()), &bound), 0);
    EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node, d.data()), force.data(), nullptr, nullptr), 0);
    return std::pair(bound, force);
  };
  const auto bound_of = [&](const phn_tool& tool, int expected) {
    double bound = -1;
    EXPECT_EQ(phn_bound(loaded.model, &tool, &bound), expected);
    return bound;
  };
  const Eigen::Vector3d d(0.003, -0.002, 0.004);
  const phn_tool node = tool(1, -1, -1, 1, 0, d[0], d[1], d[2]), between = tool(1, 2, -1, 0.4, 0.6, d[0], d[1], d[2]),
                 far = tool(1, 2, -1, 0.4, 0.6, 1, 0, 0);
  const auto [b1, f1] = at_node(1, d);
  const auto [b2, f2] = at_node(2, d);
  const Eigen::Vector3d mean = 0.4 * f1 + 0.6 * f2;
  const double spread = 0.4 * (f1 - mean).norm() + 0.6 * (f2 - mean).norm();
  const auto& c = model.bounds[0].between;
  const auto logarithm = [](double x) { return std::log(x + 1e-12); };
  const double expected = std::exp(c[0] + c[1] * logarithm(std::max(b1, b2) + spread) + c[2] * logarithm(spread) +
                                   c[3] * logarithm(mean.norm()));
  EXPECT_EQ(bound_of(node, PHN_OK), b1);
  EXPECT_NEAR(bound_of(between, PHN_OK), expected, 1e-9 * expected);
  EXPECT_EQ(bound_of(far, PHN_WARNING_OUTSIDE), PHN_NO_BOUND);
}

// Claim: beside a node, where the spread of the forces vanishes, the bound is that of the node.
TEST(BoundBetween, DoesNotVanishBesideANode) {
  Model model = with_bound_between(bent(LinearBody(7, false)));
  model.bounds[0].between = {0, 0, 1, 0};  // the spread alone
  const LoadedModel loaded(write_model_text(model));
  const Eigen::Vector3d d(0.003, -0.002, 0.004);
  double at_node = 0, beside = 0;
  EXPECT_EQ(phn_bound(loaded.model, AtNode(1, d.data()), &at_node), PHN_OK);
  const double away = 0x1p-30;
  const phn_tool place = tool(1, 2, -1, 1 - away, away, d[0], d[1], d[2]);
  EXPECT_EQ(phn_bound(loaded.model, &place, &beside), PHN_OK);
  EXPECT_GT(at_node, 0);
  // The mean of the bounds differs from the first by this weight times their difference, which is below ten times it.
  EXPECT_NEAR(beside, at_node, 10 * away * at_node);
}

}  // namespace
