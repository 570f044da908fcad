// Claims about phn_relax: closed forms, any step, the bits of elastic bodies, bad input, places that move, tools that
// only push, and passivity.
#include <gtest/gtest.h>
#include <phynness/phynness_loop.h>

#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

phn_relaxation two_terms() {
  phn_relaxation terms{};
  terms.n_terms = 2;
  terms.g[0] = 0.3, terms.tau_s[0] = 0.05;
  terms.g[1] = 0.25, terms.tau_s[1] = 2;
  terms.length_m = 0.01;
  return terms;
}

struct Relaxing {
  phn_relaxation terms = two_terms();
  phn_relaxing history{};
  int status = PHN_OK;
  Vector3d operator()(const Vector3d& elastic, double dt, const double* place = nullptr) {
    Vector3d force = Vector3d::Zero();
    status = phn_relax(&terms, &history, elastic.data(), place, dt, force.data());
    return force;
  }
};

/// Force after a ramp of the elastic force from 0 with the rate 1 for a time t, and `held` seconds of holding.
double after_ramp(const phn_relaxation& terms, double t, double held) {
  double force = t;
  for (int i = 0; i < terms.n_terms; ++i) {
    const double tau = terms.tau_s[i], lost_at_end = terms.g[i] * (t + tau * std::expm1(-t / tau));
    force -= terms.g[i] * t + (lost_at_end - terms.g[i] * t) * std::exp(-held / tau);
  }
  return force;
}

// Claim: ramp and hold are exact for steps of any length, from a millionth of the shortest time to a thousand times the
// longest, because F_e is linear within each. 1e-10: rounding of a million steps, found 2e-11.
TEST(Relaxation, IsExactForRampsInStepsOfAnyLength) {
  const auto terms = two_terms();
  for (const auto& [n, t, held] : {std::array{1e6, 0.05, 0.05},
                                   {1000., 1., 1.},
                                   {1., 0.3, 0.1},
                                   {1., 1e-7, 1e-7},
                                   {3., 2000., 1e-3},
                                   {7., 0.02, 5000.}}) {
    Relaxing relax;
    Vector3d force = Vector3d::Zero();
    for (int i = 1; i <= n; ++i) force = relax({0, 0, t * i / n}, t / n);
    EXPECT_NEAR(force[2], after_ramp(terms, t, 0), 1e-10 * t) << n << ' ' << t;
    for (int i = 0; i < n; ++i) force = relax({0, 0, t}, held / n);
    EXPECT_NEAR(force[2], after_ramp(terms, t, held), 1e-10 * t) << n << ' ' << held;
    EXPECT_EQ(force.head<2>(), Eigen::Vector2d::Zero());
  }
}

// Claim: for a sine, the error falls with the square of the step.
TEST(Relaxation, IsOfSecondOrder) {
  const auto terms = two_terms();
  const double omega = 2 * M_PI * 3;
  const auto error = [&](int n) {  // after a second, in which the start is forgotten by the first term only
    double exact = std::sin(omega);
    for (int i = 0; i < 2; ++i) {
      const double w = omega * terms.tau_s[i];
      exact -= terms.g[i] * (std::sin(omega) - w * std::cos(omega) + w * std::exp(-1 / terms.tau_s[i])) / (1 + w * w);
    }
    Relaxing relax;
    Vector3d force = Vector3d::Zero();
    for (int i = 1; i <= n; ++i) force = relax({0, std::sin(omega * i / n), 0}, 1.0 / n);
    return std::abs(force[1] - exact);
  };
  EXPECT_NEAR(error(100) / error(200), 4, 0.4);
  EXPECT_LT(error(1000), 1e-4);
}

// Claim: without terms the force has the bits of the elastic one, also of tiny and negative numbers.
TEST(Relaxation, HasTheBitsOfElasticBodies) {
  Relaxing relax;
  relax.terms.n_terms = 0;
  for (const Vector3d& elastic : {Vector3d{1.0 / 3, -1e-310, 1e299}, Vector3d{-0.0, 7, -1e-5}}) {
    const Vector3d force = relax(elastic, 1e-3);
    EXPECT_EQ(relax.status, PHN_OK);
    EXPECT_EQ(std::memcmp(force.data(), elastic.data(), sizeof(Vector3d)), 0);
  }
}

TEST(Relaxation, RefusesBadInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const Vector3d elastic(1, 2, 3);
  const double place[3] = {0, 0, infinite};
  const auto status = [&](auto&& change, double dt, const Vector3d& e, const double* at) {
    Relaxing relax;
    relax(elastic, 0.1);
    change(relax);
    const auto before = relax.history;
    EXPECT_EQ(relax(e, dt, at), Vector3d::Zero());
    EXPECT_EQ(std::memcmp(&before, &relax.history, sizeof before), 0);
    return relax.status;
  };
  const auto nothing = [](Relaxing&) {};
  for (const double dt : {0.0, -1e-3, nan, infinite}) EXPECT_EQ(status(nothing, dt, elastic, nullptr), PHN_ERROR_CLOCK);
  EXPECT_EQ(status(nothing, 1, {0, nan, 0}, nullptr), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(status(nothing, 1, {0, 0, infinite}, nullptr), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(status(nothing, 1, elastic, place), PHN_ERROR_NOT_FINITE);
  const auto of_terms = [&](auto&& change) {
    return status([&](Relaxing& r) { change(r.terms); }, 1, elastic, nullptr);
  };
  EXPECT_EQ(of_terms([](auto& t) { t.g[0] = 0.75; }), PHN_ERROR_RANGE);
  EXPECT_EQ(of_terms([](auto& t) { t.g[1] = -0.1; }), PHN_ERROR_RANGE);
  EXPECT_EQ(of_terms([](auto& t) { t.tau_s[1] = 0; }), PHN_ERROR_RANGE);
  EXPECT_EQ(of_terms([&](auto& t) { t.tau_s[0] = nan; }), PHN_ERROR_RANGE);
  EXPECT_EQ(of_terms([](auto& t) { t.n_terms = 9; }), PHN_ERROR_RANGE);
  EXPECT_EQ(of_terms([](auto& t) { t.reserved = 1; }), PHN_ERROR_VERSION);
  Vector3d force;
  phn_relaxing history{};
  EXPECT_EQ(phn_relax(nullptr, &history, elastic.data(), nullptr, 1, force.data()), PHN_ERROR_ARGUMENT);
}

// Claim: at a place far from the last one the tissue is fresh, and a warning tells until that is long ago; over one
// length e of what was lost is left, whatever the number of steps.
TEST(Relaxation, FollowsThePlace) {
  const Vector3d elastic(0, 0, 1);
  const auto lost_after = [&](double distance, int n, int& status) {
    Relaxing relax;
    double place[3] = {};
    relax(elastic, 20, place);
    const double lost = 1 - relax(elastic, 1e-9, place)[2];
    EXPECT_EQ(relax.status, PHN_OK);
    Vector3d force = Vector3d::Zero();
    for (int i = 1; i <= n; ++i) place[0] = distance * i / n, force = relax(elastic, 1e-9, place);
    status = relax.status;
    relax(elastic, 20, place);
    EXPECT_EQ(relax.status, PHN_OK);
    return (1 - force[2]) / lost;
  };
  int status = 0;
  EXPECT_NEAR(lost_after(0.01, 1, status), std::exp(-1), 1e-6);
  EXPECT_EQ(status, PHN_WARNING_RELAXATION);
  EXPECT_NEAR(lost_after(0.01, 100, status), std::exp(-1), 1e-6);
  EXPECT_NEAR(lost_after(1, 1, status), 0, 1e-6);
  EXPECT_NEAR(lost_after(1e-4, 1, status), std::exp(-0.01), 1e-6);
  EXPECT_EQ(status, PHN_OK);
}

// Claim: a tool that is held pulls when it comes back to rest; one that only pushes does not, and meets the body again
// where it has recovered to: at the elastic force whose relaxing force is 0, here by the closed form of a step.
TEST(Relaxation, ToolsThatOnlyPushNeverPull) {
  Relaxing held, pushes;
  pushes.history.outward[2] = 1;
  for (Relaxing* relax : {&held, &pushes}) (*relax)({0, 0, -1}, 1e-9), (*relax)({0, 0, -1}, 1);
  EXPECT_GT(held({0, 0, 0}, 1e-9)[2], 0.3);
  EXPECT_EQ(pushes({0, 0, 0}, 1e-9), Vector3d::Zero());
  EXPECT_EQ(pushes.status, PHN_WARNING_RELAXATION);
  const double meets = 0.3 * -std::expm1(-20.0) + 0.25 * -std::expm1(-0.5);  // F_e = sum r
  EXPECT_NEAR(-pushes.history.elastic[2], meets, 1e-6);
  EXPECT_EQ(pushes({0, 0, -0.99 * meets}, 1e-9), Vector3d::Zero());
  EXPECT_NEAR(pushes({0, 0, -1.1 * meets}, 1e-9)[2], -0.1 * meets, 1e-6);
  for (int i = 0; i < 600; ++i) pushes({0, 0, 0}, 0.1);
  EXPECT_NEAR(pushes({0, 0, -1}, 1e-9)[2], -1, 1e-6);  // all recovered
}

/// Random motion of a held tool at 1 kHz: random goals within the trained range, approached by at most 0.2 mm a cycle,
/// rests in between, and back to the start at the end.
class Motion {
 public:
  explicit Motion(double depth) : _depth(depth) {}
  Vector3d next() {
    if (_left-- == 0) {
      _goal = _depth * _numbers.vector();
      _speed = std::abs(_numbers.vector()[0]) * 2e-4;
      _left = 20 + static_cast<int>(std::abs(_numbers.vector()[0]) * 200);
    }
    const Vector3d to = _goal - _at;
    if (to.norm() > _speed) _at += _speed / to.norm() * to;
    return _at;
  }

 private:
  Numbers _numbers;
  double _depth, _speed = 0;
  int _left = 0;
  Vector3d _goal{0, 0, 0}, _at{0, 0, 0};
};

// Claim: over a million cycles of random motion the forces, each held until the next cycle, give out at most what the
// elastic ones give out under the same sampling, at every node of a model, whose energy is convex at most places; and
// the loop's observer sees the same. What the relaxing body takes is positive.
TEST(Relaxation, GivesOutNoEnergy) {
  const Model model = small_modal_model();
  const LoadedModel loaded(write_model_text(model));
  const int cycles = 1'000'000 / static_cast<int>(model.nodes.size());
  for (const ActiveNodeModel& node : model.nodes) {
    Motion motion(0.5 * model.max_displacement_m);
    Relaxing relax;
    Vector3d d = Vector3d::Zero(), elastic = Vector3d::Zero(), force = Vector3d::Zero();
    double elastic_J = 0, relaxing_J = 0, least = 0, energy = 0;
    for (int i = 0; i < cycles; ++i) {
      const Vector3d to = i + 1 < cycles ? motion.next() : Vector3d::Zero();
      elastic_J += elastic.dot(to - d);
      relaxing_J += force.dot(to - d);
      d = to;
      phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), elastic.data(), &energy, nullptr);
      force = relax(elastic, 1e-3);
      ASSERT_GE(relax.status, 0);
      least = std::min(least, relaxing_J);
    }
    EXPECT_LT(elastic_J, 0) << "sampling leaks";
    EXPECT_GE(relaxing_J, elastic_J) << node.node;
    EXPECT_GT(relaxing_J, 0) << node.node;
    EXPECT_GE(least, elastic_J) << node.node;
  }
}

// Claim: with a virtual coupling between a hand and the body, and the controller off, the loop's observer sees that a
// body that relaxes never gives out more than the elastic one does under the same sampling, and takes more in all.
TEST(Relaxation, TheObserverAgrees) {
  const Model model = small_modal_model();
  const LoadedModel loaded(write_model_text(model));
  phn_loop_settings settings;
  ASSERT_EQ(phn_loop_defaults(&settings), PHN_OK);
  settings.trip_frozen_s = settings.trip_energy_J = 0;  // the hand rests
  settings.allowance_J = 1e3;
  std::size_t bytes = 0;
  ASSERT_EQ(phn_loop_size(&bytes), PHN_OK);
  std::vector<double> memory(bytes / sizeof(double) + 1), taken, delivered;
  for (const bool relaxes : {false, true}) {
    phn_loop* loop = nullptr;
    ASSERT_EQ(phn_loop_init(memory.data(), bytes, &settings, &loop), PHN_OK);
    ASSERT_EQ(phn_loop_engage(loop), PHN_OK);
    Motion motion(0.3 * model.max_displacement_m);
    Relaxing relax;
    if (!relaxes) relax.terms.n_terms = 0;
    phn_loop_report report;
    for (int i = 1; i <= 20000; ++i) {
      const double now = 1e-3 * i;
      const Vector3d hand = motion.next();
      Vector3d tool, device, elastic;
      ASSERT_GE(phn_loop_read(loop, hand.data(), now, now, tool.data()), 0);
      phn_loop_response response{};
      response.in_contact = 1;
      response.energy = -1;
      response.status = phn_force(loaded.model, loaded.data, AtNode(model.nodes[0].node, tool.data()), elastic.data(),
                                  nullptr, nullptr);
      const Vector3d force = relax(elastic, 1e-3);
      for (int k = 0; k < 3; ++k) response.force[k] = force[k], response.displacement[k] = tool[k];
      ASSERT_GE(phn_loop_hold(loop, &response, now, device.data()), 0);
    }
    ASSERT_EQ(phn_loop_info(loop, &report), PHN_OK);
    EXPECT_EQ(report.trip, PHN_TRIP_NONE) << phn_loop_trip_message(report.trip);
    delivered.push_back(report.most_delivered_J);
    taken.push_back(report.work_J);
  }
  EXPECT_GT(taken[1], taken[0]);
  EXPECT_GT(taken[1], 0);
  EXPECT_LE(delivered[1], delivered[0]);
}

}  // namespace
