// Claim: the bound of the force's error is that of formats/model.md: linear between the displacements of the nearest
// direction, at rest the size of the force there, none outside of the trained range; a model without bounds says that
// it has none. The error of the force at rest is within its bound in every family.
#include <gtest/gtest.h>
#include <phynness/phynness_levels.h>

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
  EXPECT_EQ(phn_force(loaded.model, loaded.data, node, rest.data(), force.data(), nullptr, nullptr) < 0, false);
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
        const int status = phn_bound(loaded.model, node.node, d.data(), &bound);
        Eigen::Vector3d force;
        EXPECT_EQ(status, phn_force(loaded.model, loaded.data, node.node, d.data(), force.data(), nullptr, nullptr));
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
    EXPECT_EQ(phn_bound(loaded.model, node.node, rest, &bound) < 0, linear);
    EXPECT_LE(error, bound);
    // 1e-14: the bound is rounded up.
    EXPECT_LE(bound, error * (1 + 1e-14));
    EXPECT_EQ(error > 0, GetParam() == Family::rbfn);
  }
}

TEST_P(Bounds, AreKnownOnlyWhereTheyAreStored) {
  const double rest[] = {0, 0, 0}, far[] = {1, 0, 0}, nan = std::numeric_limits<double>::quiet_NaN(),
               no[] = {nan, 0, 0};
  const LoadedModel loaded(write_model_text(with_bounds(small_model_of(GetParam()))));
  const LoadedModel without(write_model_text(small_model_of(GetParam())));
  double bound = -1;
  EXPECT_EQ(phn_bound(loaded.model, 3, far, &bound), PHN_WARNING_OUTSIDE);
  EXPECT_EQ(bound, PHN_NO_BOUND);
  const auto refused = [&](int status, int expected) {
    EXPECT_EQ(status, expected);
    EXPECT_EQ(bound, 0);
    bound = -1;
  };
  refused(phn_bound(without.model, 3, rest, &bound), PHN_ERROR_UNDEFINED);
  refused(phn_bound(loaded.model, 4, rest, &bound), PHN_ERROR_NOT_ACTIVE);
  refused(phn_bound(loaded.model, 3, no, &bound), PHN_ERROR_NOT_FINITE);
  refused(phn_bound(nullptr, 3, rest, &bound), PHN_ERROR_ARGUMENT);
  refused(phn_bound(loaded.model, 3, nullptr, &bound), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_bound(loaded.model, 3, rest, nullptr), PHN_ERROR_ARGUMENT);
}

double logarithm(double x) { return std::log(x + 1e-12); }

class CoupledBounds : public testing::TestWithParam<bool> {
 protected:
  static Model body(bool coupled) {
    Model model = with_coupled_bounds(bent(LinearBody(7, coupled), !coupled));
    if (coupled) model.bounds[0].coupled(1, 2) = 0;  // what does not bend has no logarithm of its bending
    return model;
  }
  Model model = body(GetParam());
  LoadedModel loaded{write_model_text(model)};

  std::pair<double, Eigen::Vector3d> at_node(std::int32_t node, const Eigen::Vector3d& d) const {
    double bound = 0;
    Eigen::Vector3d force;
    EXPECT_GE(phn_bound(loaded.model, node, d.data(), &bound), 0);
    EXPECT_GE(phn_force(loaded.model, loaded.data, node, d.data(), force.data(), nullptr, nullptr), 0);
    return {bound, force};
  }
  using Forces = Eigen::Matrix<double, 3, 2>;
  static Forces forces_of(const LoadedModel& at, const std::vector<phn_tool>& tools) {
    Forces forces = Forces::Zero();
    EXPECT_GE(phn_couple(at.model, at.data, static_cast<int>(tools.size()), tools.data(), forces.data(), nullptr), 0);
    return forces;
  }
  static Eigen::Vector2d bounds_at(const LoadedModel& at, const std::vector<phn_tool>& tools, int expected) {
    Eigen::Vector2d bounds(-1, -1);
    forces_of(at, tools);
    EXPECT_EQ(phn_coupled_bound(at.model, at.data, bounds.data()), expected);
    return bounds;
  }
};
INSTANTIATE_TEST_SUITE_P(Bodies, CoupledBounds, testing::Bool(),
                         [](const auto& info) { return info.param ? "Coupled" : "Springs"; });

// Claim: one tool between nodes, and each of two tools, has the bound of the page. Stiffnesses at rest are those
// between the first displacements of the model; nodes that feel each other belong to a linear body. 1e-9: rounding of
// forces. 1e-6: of differences of forces.
TEST_P(CoupledBounds, AreThoseOfThePage) {
  const auto& c = model.bounds[0].coupled;
  const LoadedModel old(write_model_text(with_bounds(bent(LinearBody(7, GetParam())))));
  const Eigen::Vector3d d(0.003, -0.002, 0.004), e(-0.004, 0.001, 0.002);
  const auto both = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::vector{tool(1, -1, -1, 1, 0, a[0], a[1], a[2]), tool(4, -1, -1, 1, 0, b[0], b[1], b[2])};
  };
  const std::vector<phn_tool> between = {tool(1, 2, -1, 0.4, 0.6, d[0], d[1], d[2])}, two = both(d, e), node = {two[0]};
  const auto [b1, f1] = at_node(1, d);
  const auto [b2, f2] = at_node(2, d);
  const auto [b4, f4] = at_node(4, e);
  EXPECT_EQ(bounds_at(loaded, node, PHN_OK)[0], b1);
  if (!GetParam()) {  // springs: the tool between nodes is answered by them alone
    const Eigen::Vector3d mean = 0.4 * f1 + 0.6 * f2;
    const double spread = 0.4 * (f1 - mean).norm() + 0.6 * (f2 - mean).norm();
    const double expected = std::exp(c(0, 0) + c(0, 1) * logarithm(std::max(b1, b2) + spread) +
                                     c(0, 2) * logarithm(spread) + c(0, 3) * logarithm(mean.norm()));
    EXPECT_NEAR(bounds_at(loaded, between, PHN_OK)[0], expected, 1e-9 * expected);
  }

  const Forces forces = forces_of(loaded, two);
  const double h = model.displacements.row(0).norm();
  Eigen::Matrix3d alone[2], stiffness[2][2];
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k), zero = Eigen::Vector3d::Zero();
    for (const int s : {0, 1}) {
      const std::int32_t at = s == 0 ? 1 : 4;
      alone[s].col(k) = (at_node(at, step).second - at_node(at, -step).second) / (2 * h);
      const Forces change = (forces_of(loaded, s == 0 ? both(step, zero) : both(zero, step)) -
                             forces_of(loaded, s == 0 ? both(-step, zero) : both(zero, -step))) /
                            (2 * h);
      for (const int t : {0, 1}) stiffness[t][s].col(k) = change.col(t);
    }
  }
  for (const int t : {0, 1})
    for (auto* matrix : {&alone[t], &stiffness[t][t]}) *matrix = (*matrix + matrix->transpose()).eval() / 2;
  const Eigen::Vector2d said = bounds_at(loaded, two, PHN_OK);
  const double own[] = {b1, b4};
  for (const int t : {0, 1}) {
    double reaching = 0;
    for (const int s : {0, 1}) reaching += (stiffness[t][s] * alone[s].inverse()).norm() / std::sqrt(3) * own[s];
    const double bend = GetParam() ? 0 : (forces.col(t) - stiffness[t][0] * d - stiffness[t][1] * e).norm();
    const double of_two = std::exp(c(1, 0) + c(1, 1) * logarithm(reaching) + c(1, 2) * logarithm(bend) +
                                   c(1, 3) * logarithm(forces.colwise().norm().sum()));
    EXPECT_NEAR(said[t], of_two, 1e-6 * of_two);
  }
  EXPECT_EQ(bounds_at(loaded, both(d, {1, 0, 0}), PHN_WARNING_OUTSIDE), Eigen::Vector2d::Constant(PHN_NO_BOUND));
  EXPECT_EQ(bounds_at(old, node, PHN_OK)[0], b1);
  EXPECT_EQ(bounds_at(old, two, PHN_ERROR_UNDEFINED), Eigen::Vector2d::Zero());
  EXPECT_EQ(bounds_at(old, between, PHN_ERROR_UNDEFINED)[0], 0);
}

// Claim: without tools, and for a smaller level, there is no bound, and that is said.
TEST(CoupledBoundsOfLevels, AreUndefined) {
  const LoadedModel loaded(write_model_text(with_coupled_bounds(with_levels(small_model_of(Family::modal)))));
  const std::vector<phn_tool> two = {tool(3, -1, -1, 1, 0, 0.001, 0, 0), tool(5, -1, -1, 1, 0, 0, 0.001, 0)};
  double bounds[] = {-1, -1}, forces[6];
  EXPECT_EQ(phn_coupled_bound(loaded.model, loaded.data, bounds), PHN_ERROR_UNDEFINED);
  EXPECT_GE(phn_couple(loaded.model, loaded.data, 2, two.data(), forces, nullptr), 0);
  EXPECT_GE(phn_coupled_bound(loaded.model, loaded.data, bounds), 0);
  EXPECT_GT(bounds[0], 0);
  EXPECT_EQ(phn_set_level(loaded.model, loaded.data, 0), PHN_OK);
  EXPECT_GE(phn_couple(loaded.model, loaded.data, 2, two.data(), forces, nullptr), 0);
  EXPECT_EQ(phn_coupled_bound(loaded.model, loaded.data, bounds), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(bounds[0], 0);
}

// Claim: nothing else that the runtime computes changes when bounds are added.
TEST_P(Bounds, ChangeNothingElse) {
  const LoadedModel with(write_model_text(with_bounds(small_model_of(GetParam())))),
      without(write_model_text(small_model_of(GetParam())));
  Numbers numbers;
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d d = 0.012 * numbers.vector();
    Eigen::Vector3d a, b;
    EXPECT_EQ(phn_force(with.model, with.data, 5, d.data(), a.data(), nullptr, nullptr),
              phn_force(without.model, without.data, 5, d.data(), b.data(), nullptr, nullptr));
    EXPECT_EQ(a, b);
  }
}

}  // namespace
