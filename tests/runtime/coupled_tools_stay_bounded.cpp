#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "linear_body.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

class BoundedToolsOf : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, BoundedToolsOf, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

// Claim: tools too near each other to follow each other's contradictions say so, and give forces that a device can
// render: opposed they may be 1 / (2 least_apart) = 10 times what linear tools would feel alone at their displacements.
TEST_P(BoundedToolsOf, ForcesAreBounded) {
  const LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  int n_given_up = 0;
  for (const double apart : {1e-3, 1e-5, 1e-7, 0.0}) {
    const phn_tool tools[2] = {tool(3, 5, 8, 0.4, 0.3, 0.005, 0.004, -0.003),
                               tool(3, 5, 8, 0.4 - apart, 0.3 + apart, -0.004, 0.005, 0.002)};
    Eigen::Vector3d alone[2];
    Eigen::Matrix<double, 3, 2> forces;
    for (int t = 0; t < 2; ++t)
      ASSERT_GE(phn_couple(loaded.model, loaded.data, 1, tools + t, alone[t].data(), nullptr), 0);
    const int status = phn_couple(loaded.model, loaded.data, 2, tools, forces.data(), nullptr);
    ASSERT_GE(status, 0);
    n_given_up += (status & PHN_WARNING_UNSETTLED) != 0;
    for (int t = 0; t < 2; ++t) EXPECT_LE(forces.col(t).norm(), 10 * (alone[0].norm() + alone[1].norm()));
  }
  EXPECT_GT(n_given_up, 1);
}

// Claim: tools near each other that ask for the same are felt together as one tool is, the better the closer
// they are: what they ask for does not contradict itself. The body bends so much that two nodes' responses to
// each other differ by up to 8 %; at a place that is the same what is left are the 1e-5 of 16-bit tables.
TEST(CoupledTools, ThatAgreeAreFeltAsOne) {
  const LinearBody body(7);
  Model model = bent(body);
  for (ActiveNodeModel& node : model.nodes) {
    node.conservative.coefficients *= 6;
    Eigen::MatrixXd weights = node.modal.weights.values();
    weights.topRows(4) *= 6;
    node.modal.weights = scaled_table(weights);
  }
  const LoadedModel loaded(write_model_text(model));
  for (const double apart : {1e-2, 1e-3, 1e-4, 1e-5, 1e-7, 1e-9, 0.0})
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d d(0.009 * sign, 0.007, -0.005 * sign);
      const phn_tool tools[2] = {tool(1, 2, 3, 0.4, 0.3, d[0], d[1], d[2]),
                                 tool(1, 2, 3, 0.4 - apart, 0.3 + apart, d[0], d[1], d[2])};
      Eigen::Vector3d one;
      Eigen::Matrix<double, 3, 2> forces;
      ASSERT_GE(phn_couple(loaded.model, loaded.data, 1, tools, one.data(), nullptr), 0);
      ASSERT_GE(phn_couple(loaded.model, loaded.data, 2, tools, forces.data(), nullptr), 0);
      EXPECT_LT((forces.rowwise().sum() - one).norm(), (2 * apart + 1e-4) * one.norm()) << apart;
    }
}

// Claim: two tools that come together, meet and part feel no jump: a step of 1e-6 of the weights on the way
// changes forces by no more than 1e-3 of the largest.
TEST(CoupledTools, MeetWithoutAJump) {
  const LinearBody body(7);
  const LoadedModel loaded(write_model_text(bent(body)));
  const auto forces_at = [&](double apart) {
    const phn_tool tools[2] = {tool(1, 2, 3, 0.4, 0.3, 0.005, 0.004, -0.002),
                               tool(1, 2, 3, 0.4 - apart, 0.3 + apart, -0.003, 0.006, 0.001)};
    Eigen::Matrix<double, 6, 1> forces;
    EXPECT_GE(phn_couple(loaded.model, loaded.data, 2, tools, forces.data(), nullptr), 0);
    return forces;
  };
  for (double apart = -0.25; apart < 0.35; apart += 0.004) {
    const auto here = forces_at(apart), there = forces_at(apart + 1e-6);
    EXPECT_LT((there - here).norm(), 1e-3 * here.norm()) << apart;
  }
}

// Claim: forces are continuous where a tool slides over an edge or a node, and the answer is the same whatever was
// asked before. Both triangles see the edge's own problem, so that a step of 1e-9 changes the force by some 1e-9 of it;
// substitution ends at 1e-9, too. The body is curved: the force differs from the linear one by percents.
TEST(SlidingTools, KeepTheirForceOverEdges) {
  const LinearBody body(7);
  const LoadedModel loaded(write_model_text(bent(body))), linear(write_model_text(body.model));
  const auto force = [](const LoadedModel& model, const phn_tool& at) {
    Eigen::Vector3d f;
    EXPECT_EQ(phn_couple(model.model, model.data, 1, &at, f.data(), nullptr) & PHN_WARNING_UNSETTLED, 0);
    return f;
  };
  const double step = 1e-9;
  const phn_tool on = tool(1, 2, 3, 0.6, 0.4, 0.005, 0.004, -0.002);
  const Eigen::Vector3d f = force(loaded, on);
  const Eigen::Vector3d before = force(loaded, tool(1, 2, 3, 0.6, 0.4 - step, 0.005, 0.004, -0.002));
  const Eigen::Vector3d after = force(loaded, tool(2, 1, 0, 0.4, 0.6 - step, 0.005, 0.004, -0.002));
  EXPECT_EQ(force(loaded, on), f);
  EXPECT_LT((before - f).norm(), 1e-7 * f.norm());
  EXPECT_LT((after - f).norm(), 1e-7 * f.norm());
  EXPECT_GT((force(linear, on) - f).norm(), 1e-3 * f.norm());
  const Eigen::Vector3d at_node = force(loaded, tool(1, -1, -1, 1, 0, 0.005, 0.004, -0.002));
  const Eigen::Vector3d near_node = force(loaded, tool(1, 2, 3, 1 - 2 * step, step, 0.005, 0.004, -0.002));
  EXPECT_LT((near_node - at_node).norm(), 1e-7 * at_node.norm());
}

// Claim: what makes no sense is refused with zeros, and everything else gives finite numbers.
TEST_P(BoundedToolsOf, AnswerOrRefuseEveryInput) {
  const LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  const auto status = [&](std::vector<phn_tool> tools) {
    std::vector<double> forces(3 * tools.size() + 3, nan);
    phn_coupled result = {nan, nan};
    const int said =
        phn_couple(loaded.model, loaded.data, static_cast<int>(tools.size()), tools.data(), forces.data(), &result);
    for (std::size_t i = 0; i < 3 * tools.size(); ++i)
      EXPECT_TRUE(said < 0 ? forces[i] == 0 : std::isfinite(forces[i])) << said;
    EXPECT_TRUE(std::isfinite(result.residual) && std::isfinite(result.energy));
    Points field = Points::Constant(12, 3, nan);
    EXPECT_GE(phn_coupled_deform(loaded.model, loaded.data, field.data()), 0);
    EXPECT_TRUE(field.allFinite());
    return said;
  };
  const phn_tool good = tool(3, 5, 8, 0.5, 0.25, 0.001, 0, 0);
  EXPECT_GE(status({good}), 0);
  EXPECT_EQ(status({}), PHN_OK);
  EXPECT_EQ(status({tool(3, 5, 8, nan, 0.25, 0.001, 0, 0)}), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(status({tool(3, 5, 8, -0.5, 1, 0.001, 0, 0)}), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(status({{{3, 5, 8}, {0.5, 0.5, 0.5}, {0, 0, 0}}}), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(status({tool(3, 5, 8, 0.5, 0.25, nan, 0, 0)}), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(status({tool(3, 5, 8, 0.5, 0.25, inf, 0, 0)}), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(status({tool(3, 5, 12, 0.5, 0.25, 0.001, 0, 0)}), PHN_ERROR_NOT_ACTIVE);
  // Of a point on an edge, phn_nearest leaves rounding at the opposite corner, which need not be active.
  EXPECT_GE(status({{{3, 5, 12}, {0.5, 0.5, 2e-16}, {0.001, 0, 0}}}), 0);
  EXPECT_EQ(status({tool(3, 5, 1000, 0.5, 0.25, 0.001, 0, 0)}), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(status({tool(0, 1, -1, 0.5, 0.5, 0.001, 0, 0)}), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(status({tool(3, 5, 15, 0.5, 0.25, 0.001, 0, 0)}), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(status(std::vector<phn_tool>(5, good)), PHN_ERROR_TOOLS);
  EXPECT_GE(status({good, good}), 0);  // one point twice: no answer fits unless the tools agree
  for (const double size : {1e-320, 1e-100, 1e-3, 1.0, 1e30, 1e300}) {
    EXPECT_GE(status({tool(3, 5, 8, 0.5, 0.25, size, -size, size)}), 0);
    EXPECT_GE(status({good, tool(5, 8, 3, 0.5, 0.25, size, size, 0)}), 0);
    EXPECT_GE(status({tool(3, 5, 8, 1, 0, size, -size, size)}), 0);
  }
  double forces[3];
  EXPECT_EQ(phn_couple(nullptr, loaded.data, 1, &good, forces, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_couple(loaded.model, nullptr, 1, &good, forces, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_couple(loaded.model, loaded.data, 1, nullptr, forces, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_couple(loaded.model, loaded.data, -1, &good, forces, nullptr), PHN_ERROR_ARGUMENT);
}

// Claim: phn_nearest finds the point that a search over a fine grid of every triangle finds among those that phn_force
// answers, and says its distance; its tool is answered, also where it was moved away from a fixed edge.
TEST(Nearest, IsTheNearestPlaceThatAnswers) {
  const Model model = small_model();
  const LoadedModel loaded(write_model_text(model));
  const auto point_of = [&](std::int32_t node) {
    return Eigen::Vector3d(node < 2 ? model.fixed_points.row(node) : model.output_points.row(node - 2));
  };
  constexpr int n = 60;
  int n_compared = 0;
  std::vector<Eigen::Vector3d> grid;  // of what is answered
  for (Eigen::Index t = 0; t < model.surface.rows(); ++t)
    for (int a = 0; a <= n; ++a)
      for (int b = 0; b + a <= n; ++b) {
        const int w[3] = {a, b, n - a - b};
        phn_tool tool = {{-1, -1, -1}, {0, 0, 0}, {0, 0, 0}};
        Eigen::Vector3d p(0, 0, 0);
        double force[3];
        for (int k = 0; k < 3; ++k) {
          tool.nodes[k] = model.surface(t, k) < 2 ? model.fixed[static_cast<std::size_t>(model.surface(t, k))]
                                                  : model.output[static_cast<std::size_t>(model.surface(t, k) - 2)];
          tool.weights[k] = double(w[k]) / n;
          p += tool.weights[k] * point_of(model.surface(t, k));
        }
        if (phn_force(loaded.model, loaded.data, &tool, force, nullptr, nullptr) >= 0) grid.push_back(p);
      }
  Numbers numbers;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x(0.1 * numbers.next(), 0.1 * numbers.next(), 0.1 * numbers.next());
    phn_tool found;
    Eigen::Vector3d point;
    double distance = -1, force[3];
    ASSERT_EQ(phn_nearest(loaded.model, x.data(), &found, point.data(), &distance), PHN_OK);
    EXPECT_NEAR(std::abs(distance), (point - x).norm(), 1e-15);
    EXPECT_GE(phn_force(loaded.model, loaded.data, &found, force, nullptr, nullptr), 0);
    Eigen::Vector3d said(0, 0, 0);
    double sum = 0;
    for (int k = 0; k < 3 && found.nodes[k] >= 0; ++k) {
      EXPECT_GE(found.weights[k], 0);
      sum += found.weights[k];
      said += found.weights[k] * point_of(found.nodes[k]);
    }
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_LT((said - point).norm(), 1e-15);
    double fixed = 0, least = inf;
    for (int k = 0; k < 3; ++k) fixed += found.nodes[k] == 0 || found.nodes[k] == 1 ? found.weights[k] : 0;
    if (fixed > 0.95 - 1e-12) continue;  // moved away from a fixed edge
    for (const Eigen::Vector3d& p : grid) least = std::min(least, (p - x).norm());
    EXPECT_LE((point - x).norm(), least + 1e-15);
    EXPECT_GE((point - x).norm(), least - 0.1 / n);  // edges are shorter than 0.2 m: no grid point is further off
    ++n_compared;
  }
  EXPECT_GT(n_compared, 100);
  phn_tool found;
  const double bad[3] = {nan, 0, 0};
  EXPECT_EQ(phn_nearest(loaded.model, bad, &found, nullptr, nullptr), PHN_ERROR_NOT_FINITE);
  Model bare = model;
  bare.surface.resize(0, 3);
  const LoadedModel without(write_model_text(bare));
  const double x[3] = {0, 0, 0};
  EXPECT_EQ(phn_nearest(without.model, x, &found, nullptr, nullptr), PHN_ERROR_UNDEFINED);
}

}  // namespace
