// Claims about several round tools: each has the compliance of (x), and the others see it where superposition says.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "linear_body.hpp"
#include "loaded_model.hpp"
#include "small_model.hpp"
#include "tools/local_response.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// A linear body whose tools move means over a node, and over the two nodes with the next numbers.
/// @param apart  if positive, over all nodes alike, and by this part over their own
struct RoundBody : LinearBody {
  Eigen::MatrixXd weights;  ///< n x n, of the tool at node i in row i

  explicit RoundBody(int n, double apart = 0) : LinearBody(n), weights(Eigen::MatrixXd::Zero(n, n)) {
    for (int i = 0; i < n; ++i) {
      ActiveNodeModel& node = model.nodes[static_cast<std::size_t>(i)];
      for (int k = 0; k < 3; ++k) weights(i, (i + k) % n) = k == 0 ? 0.5 : 0.25;
      if (apart > 0)
        weights.row(i) = (Eigen::VectorXd::Constant(n, (1 - apart) / n) + apart * Eigen::VectorXd::Unit(n, i));
      node.moves_mean = true;
      node.prescribed.clear();
      node.prescribed_weight.clear();
      for (int j = 0; j < n; ++j) {
        if (weights(i, j) == 0) continue;
        node.prescribed.push_back(j);
        node.prescribed_weight.push_back(weights(i, j));
      }
      const Eigen::MatrixXd w = mean_of(weights.row(i));
      const Eigen::Matrix3d K = Eigen::Matrix3d(w * compliance * w.transpose()).inverse();
      const Eigen::MatrixXd U = compliance * w.transpose() * K;
      node.linear.stiffness = (K + K.transpose()) / 2;
      for (int o = 0; o < n; ++o)
        for (int axis = 0; axis < 3; ++axis)
          for (int k = 0; k < 3; ++k) node.linear.unit_responses(o, 3 * axis + k) = U(3 * o + k, axis);
    }
  }
  /// 3 x 3 n: the mean of displacements.
  static Eigen::MatrixXd mean_of(const Eigen::RowVectorXd& w) {
    Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(3, 3 * w.size());
    for (Eigen::Index i = 0; i < w.size(); ++i) mean.middleCols<3>(3 * i) = w[i] * Eigen::Matrix3d::Identity();
    return mean;
  }
};

struct Answer {
  int status = 0;
  Eigen::VectorXd forces;
  phn_coupled result = {};
};
Answer coupled(const LoadedModel& loaded, const std::vector<phn_tool>& tools) {
  Answer a;
  a.forces.resize(static_cast<Eigen::Index>(3 * tools.size()));
  a.status =
      phn_couple(loaded.model, loaded.data, static_cast<int>(tools.size()), tools.data(), a.forces.data(), &a.result);
  return a;
}

const phn_tool first = tool(0, 1, 2, 0.2, 0.5, 0.005, -0.004, 0.003), second = tool(4, 5, 6, 0.3, 0.3, 0, 0, 0),
               beside = tool(2, 3, 4, 0.3, 0.3, 0, 0, 0);

// Claim: at nodes, tools of a linear body superpose exactly where they can be distinguished: forces and field are those
// of the problem in which the means are given. 1e-10 leaves room for the conditioning of a dozen unknowns.
// They can also where opposing displacements have a fortieth of a tool's own compliance (`apart` 0.06), but not where
// they have a thousandth (0.01).
TEST(CoupledRoundTools, AreExactAtNodes) {
  const std::vector<int> one = {0, 3}, three = {1, 4, 6}, other = {2, 3};
  for (const auto& [apart, nodes] : {std::pair{0.0, one}, {0.0, three}, {0.0, other}, {0.06, one}, {0.06, three}}) {
    const RoundBody body(7, apart);
    const LoadedModel loaded(write_model_text(body.model));
    const auto n = static_cast<Eigen::Index>(nodes.size());
    std::vector<phn_tool> tools;
    Eigen::MatrixXd B(3 * n, 21);
    Eigen::VectorXd d = Eigen::VectorXd::LinSpaced(3 * n, -0.01, 0.02);
    for (Eigen::Index t = 0; t < n; ++t) {
      const int node = nodes[static_cast<std::size_t>(t)];
      tools.push_back(tool(node, -1, -1, 1, 0, d[3 * t], d[3 * t + 1], d[3 * t + 2]));
      B.middleRows<3>(3 * t) = RoundBody::mean_of(body.weights.row(node));
    }
    const Eigen::VectorXd F = (B * body.compliance * B.transpose()).ldlt().solve(d);
    const Eigen::VectorXd u = body.compliance * B.transpose() * F;
    Eigen::VectorXd field(21);
    const Answer said = coupled(loaded, tools);
    EXPECT_EQ(said.status, PHN_OK);
    EXPECT_EQ(phn_coupled_deform(loaded.model, loaded.data, field.data()), PHN_OK);
    EXPECT_LT((said.forces - F).norm(), 1e-10 * F.norm());
    EXPECT_LT((field - u).norm(), 1e-10 * u.norm());
  }
}

TEST(CoupledRoundTools, AreUnsettledWhereTheyAreNearlyOne) {
  const LoadedModel loaded(write_model_text(RoundBody(7, 0.01).model));
  const phn_tool one = tool(0, -1, -1, 1, 0, 0.005, 0, 0), opposed = tool(3, -1, -1, 1, 0, -0.005, 0, 0);
  EXPECT_EQ(coupled(loaded, {one, opposed}).status, PHN_WARNING_UNSETTLED);
}

// Claim: near round tools that work against each other are outside of the trained range where the force of one is
// larger than it had alone at its trained depth, also in the status of the field and of the bound, which there is none;
// tools that move alike are not, nor is a small difference, nor a body that is linear at any depth. Displacements are
// within half of the trained depth.
TEST(CoupledRoundTools, AreOutsideWhereForcesAreLargerThanTrained) {
  const RoundBody body(7, 0.2);
  const LoadedModel curved(write_model_text(with_coupled_bounds(bent(body)))), linear(write_model_text(body.model));
  const auto pair = [](double one, double other) {
    return std::vector{tool(0, -1, -1, 1, 0, one, 0, 0), tool(3, -1, -1, 1, 0, other, 0, 0)};
  };
  const double deepest[3] = {0.01, 0, 0};
  double alone[3], field[21], bounds[2];
  ASSERT_EQ(phn_force(curved.model, curved.data, 0, deepest, alone, nullptr, nullptr), PHN_OK);
  const Answer opposed = coupled(curved, pair(0.005, -0.005));
  EXPECT_GT(opposed.forces.head<3>().norm(), 2 * Eigen::Map<Eigen::Vector3d>(alone).norm());
  EXPECT_EQ(opposed.status, PHN_WARNING_OUTSIDE);
  EXPECT_EQ(phn_coupled_deform(curved.model, curved.data, field), PHN_WARNING_OUTSIDE);
  EXPECT_EQ(phn_coupled_bound(curved.model, curved.data, bounds), PHN_WARNING_OUTSIDE);
  EXPECT_EQ(bounds[0], PHN_NO_BOUND);
  EXPECT_EQ(coupled(curved, pair(0.005, 0.005)).status, PHN_OK);
  EXPECT_EQ(phn_coupled_deform(curved.model, curved.data, field), PHN_OK);
  EXPECT_EQ(phn_coupled_bound(curved.model, curved.data, bounds), PHN_OK);
  EXPECT_LT(bounds[0], PHN_NO_BOUND);
  EXPECT_EQ(coupled(curved, pair(5e-5, -5e-5)).status, PHN_OK);
  EXPECT_EQ(coupled(linear, pair(0.005, -0.005)).status, PHN_OK);
}

// Claim: round tools that are pulled apart are held more firmly than by the undeformed body, and those that are pushed
// together less, by the square of the displacement, as Green's strain of their distance says. The same body with
// coordinates a million times as large has no such part; without triangles, neither of them turns. Halves of the
// displacement have a quarter of it, but for 3 % of higher powers.
TEST(CoupledRoundTools, StiffenWherePulledApart) {
  Model near = bent(RoundBody(7)), far = near;
  near.surface.resize(0, 3);
  far.surface.resize(0, 3);
  for (auto& node : far.nodes)
    for (double& x : node.point) x *= 1e6;
  far.output_points *= 1e6;
  const LoadedModel loaded(write_model_text(near)), without(write_model_text(far));
  const Eigen::Vector3d apart = (near.output_points.row(3) - near.output_points.row(0)).normalized().transpose();
  const auto change = [&](double d) {
    const Eigen::Vector3d u = d * apart;
    const std::vector<phn_tool> tools = {tool(0, -1, -1, 1, 0, -u[0], -u[1], -u[2]),
                                         tool(3, -1, -1, 1, 0, u[0], u[1], u[2])};
    return apart.dot((coupled(loaded, tools).forces - coupled(without, tools).forces).tail<3>());
  };
  for (const double d : {1e-4, -1e-4}) {
    EXPECT_GT(change(d), 0);
    EXPECT_NEAR(change(d) / change(d / 2), 4, 0.12);
  }
}

// Claim: the stiffness of a round tool at rest is that of the undeformed body and not of the whole first increment: of
// the difference between these, which grows with the square of the step, at most a fifth is left.
TEST(CoupledRoundTools, StartFromTheUndeformedBody) {
  Model model = bent(RoundBody(7));
  for (auto& node : model.nodes) node.conservative.coefficients.setConstant(0.02);
  const LoadedModel loaded(write_model_text(model));
  Eigen::Matrix3d secant, rest;
  double force[3];
  const double none[3] = {0, 0, 0}, first = loaded.model->first_increment;
  ASSERT_EQ(phn_force(loaded.model, loaded.data, 0, none, force, nullptr, rest.data()), PHN_OK);
  for (int k = 0; k < 3; ++k) {
    double sides[2][3];
    for (const int side : {0, 1}) {
      const Eigen::Vector3d d = (side == 0 ? first : -first) * Eigen::Vector3d::Unit(k);
      phn_force(loaded.model, loaded.data, 0, d.data(), sides[side], nullptr, nullptr);
    }
    for (int i = 0; i < 3; ++i) secant(i, k) = (sides[0][i] - sides[1][i]) / (2 * first);
  }
  const runtime::Matrix said = runtime::stiffness_at_rest(*loaded.model, loaded.model->active[0]);
  EXPECT_GT((secant - rest).norm(), 1e-3 * rest.norm());
  EXPECT_LT((Eigen::Map<const Eigen::Matrix3d>(said.a) - rest).norm(), 0.2 * (secant - rest).norm());
}

/// Displacement of the second tool for which it exerts no force: Newton's method with differences.
phn_tool without_force(const LoadedModel& loaded, const phn_tool& one, phn_tool other, double h) {
  for (int step = 0; step < 12; ++step) {
    const Eigen::Vector3d force = coupled(loaded, {one, other}).forces.tail<3>();
    Eigen::Matrix3d slope;
    for (int k = 0; k < 3; ++k) {
      phn_tool more = other;
      more.displacement[k] += h;
      slope.col(k) = (coupled(loaded, {one, more}).forces.tail<3>() - force) / h;
    }
    Eigen::Map<Eigen::Vector3d>(other.displacement) -= slope.inverse() * force;
  }
  return other;
}

// Claim: a second tool that exerts no force leaves force and energy of the first as they are alone, at nodes and
// between them, in linear and nonlinear bodies. 1e-9: what Newton's method leaves of the second force. Without the
// compliance of (x) the first force is another one, and so it is with superposed tools.
TEST(CoupledRoundTools, WithoutForceAreNotFelt) {
  const RoundBody body(7);
  for (const bool curved : {false, true}) {
    const LoadedModel loaded(write_model_text(curved ? bent(body) : body.model));
    for (const phn_tool& one : {first, tool(1, -1, -1, 1, 0, 0.004, 0.003, -0.002)})
      for (const phn_tool& two : {second, tool(5, -1, -1, 1, 0, 0, 0, 0)}) {
        const Answer alone = coupled(loaded, {one}),
                     both = coupled(loaded, {one, without_force(loaded, one, two, 1e-7)});
        EXPECT_EQ(both.status, PHN_OK);
        EXPECT_LT(both.forces.tail<3>().norm(), 1e-9 * alone.forces.norm());
        EXPECT_LT((both.forces.head<3>() - alone.forces).norm(), 1e-9 * alone.forces.norm());
        EXPECT_NEAR(both.result.energy, alone.result.energy, 1e-9 * alone.result.energy);
      }
  }
}

// Claim: the stiffness of tools anywhere is symmetric and positive definite, and if they are at one place, they are not
// distinguished.
TEST(CoupledRoundTools, HavePositiveStiffness) {
  const RoundBody body(7);
  const LoadedModel loaded(write_model_text(body.model));
  Numbers numbers;
  for (int pair = 0; pair < 50; ++pair) {
    std::vector<phn_tool> tools;
    for (int t = 0; t < 2; ++t) {
      const double a = std::abs(numbers.next()) / 2, b = std::abs(numbers.next()) / 2;
      const int node = (3 * pair + (1 + pair / 7) * t) % 6;
      tools.push_back(tool(node, (node + 1) % 7, (node + 2) % 7, a, b, 0, 0, 0));
    }
    Eigen::Matrix<double, 6, 6> K;
    for (int i = 0; i < 6; ++i) {
      auto moved = tools;
      moved[static_cast<std::size_t>(i / 3)].displacement[i % 3] = 1;
      K.col(i) = coupled(loaded, moved).forces;
    }
    EXPECT_LT((K - K.transpose()).norm(), 1e-9 * K.norm());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(K);
    EXPECT_GT(modes.eigenvalues()[0], 1e-9 * K.norm()) << pair;
  }
  phn_tool opposed = first;
  for (double& d : opposed.displacement) d = -d;
  EXPECT_EQ(coupled(loaded, {first, opposed}).status, PHN_WARNING_UNSETTLED);
}

// Claim: forces are the gradient of the energy, also of tools that touch the same nodes, where they are larger than in
// training. Central differences of 1e-6 m
// leave 1e-8 of the force, and energies to 16 digits ten.
TEST(CoupledRoundTools, HaveForcesThatAreGradients) {
  const LoadedModel loaded(write_model_text(bent(RoundBody(7))));
  for (const phn_tool& other : {second, beside}) {
    std::vector<phn_tool> tools = {first, other};
    tools[1].displacement[0] = 0.002;
    tools[1].displacement[2] = -0.006;
    const Answer here = coupled(loaded, tools);
    ASSERT_EQ(here.status & PHN_WARNING_UNSETTLED, 0);
    for (int i = 0; i < 6; ++i) {
      double energy[2];
      for (const int side : {0, 1}) {
        auto moved = tools;
        moved[static_cast<std::size_t>(i / 3)].displacement[i % 3] += side == 0 ? -1e-6 : 1e-6;
        energy[side] = coupled(loaded, moved).result.energy;
      }
      EXPECT_NEAR((energy[1] - energy[0]) / 2e-6, here.forces[i], 1e-7 * here.forces.norm());
    }
  }
}

// Claim: how tools are numbered, and how their corners are ordered, is nothing to the answer; forces change little
// where a tool slides over an edge. 1e-9: sums in another order. 1e-9 of a weight moves a force by a hundred times as
// much.
TEST(CoupledRoundTools, AreTheSameInAnyOrderAndSlideOverEdges) {
  const LoadedModel loaded(write_model_text(bent(RoundBody(7))));
  phn_tool other = second;
  other.displacement[1] = 0.003;
  const phn_tool turned = tool(6, 4, 5, 0.4, 0.3, 0, 0.003, 0);
  const Answer there = coupled(loaded, {first, other}), back = coupled(loaded, {turned, first});
  EXPECT_LT((there.forces.head<3>() - back.forces.tail<3>()).norm(), 1e-9 * there.forces.norm());
  EXPECT_LT((there.forces.tail<3>() - back.forces.head<3>()).norm(), 1e-9 * there.forces.norm());
  const phn_tool sides[2] = {tool(4, 5, 6, 0.4 - 1e-9, 0.6, 0, 0.003, 0), tool(5, 6, 4, 0.6, 0, 0, 0.003, 0)};
  const Answer inside = coupled(loaded, {first, sides[0]}), edge = coupled(loaded, {first, sides[1]});
  EXPECT_LT((inside.forces - edge.forces).norm(), 1e-7 * edge.forces.norm());
}

}  // namespace
