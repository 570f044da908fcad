#include <gtest/gtest.h>

#include <thread>

#include "../contact/bodies.hpp"
#include "force_thread.hpp"
#include "loaded_model.hpp"
#include "simulated_device.hpp"
#include "small_model.hpp"

namespace {
thread_local long n_allocations = 0;
}

// Replaces the allocator of this program: libstdc++'s operator new ends here, too.
extern "C" {
void* __libc_malloc(std::size_t);
void* malloc(std::size_t bytes) {
  ++n_allocations;
  return __libc_malloc(bytes);
}
}

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double largest_displacement_m = 0.02;

/// Tissue of one stiffness at node 3 [N/m].
Model spring(double stiffness) {
  Model model = small_model_of(Family::linear);
  for (auto& node : model.nodes) node.linear.stiffness = stiffness * Eigen::Matrix3d::Identity();
  return model;
}

struct Loop {
  Loop(const Model& model, const LoopSettings& settings, double reach_m)
      : loaded(write_model_text(model)),
        loop(settings, loaded.model, loaded.data, 3),
        device({}, HandMotion(reach_m)) {}
  Vector3 cycle(bool stalled = false) {
    const auto sample = device.read();
    const Vector3 force = loop.step(sample.position, sample.cycle, ++now);
    device.hold(force, stalled);
    return force;
  }
  LoadedModel loaded;
  ForceThread loop;
  SimulatedDevice device;
  long now = 0;
};

LoopSettings settings() {
  LoopSettings s;
  s.largest_displacement_m = largest_displacement_m;
  return s;
}

// Claim: what the reader gets is whole and never older than what it got before, however fast the writer is.
TEST(Latest, IsWholeAndNeverGoesBack) {
  struct Value {
    long first = 0, copies[30] = {};
  };
  Latest<Value> latest;
  constexpr long last = 300'000;
  std::thread writer([&] {
    for (long i = 1; i <= last; ++i) {
      Value value;
      value.first = i;
      std::fill(std::begin(value.copies), std::end(value.copies), i);
      latest.write(value);
    }
  });
  long before = 0, torn = 0, back = 0;
  while (before < last) {
    Value value;
    const bool is_new = latest.read(value);
    for (const long copy : value.copies) torn += copy != value.first;
    back += is_new ? value.first <= before : value.first != before;
    before = value.first;
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(back, 0);
}

// Claim: at rest against tissue the force is that of coupling and tissue in series, to the device's
// resolution.
TEST(HapticLoop, SettlesWhereCouplingAndTissueBalance) {
  Loop loop(spring(600), settings(), 0);
  Vector3 force;
  const Vector3 held{0.006, 0, -0.008};
  for (long i = 1; i < 200; ++i) force = loop.loop.step(held, i, i);
  const double expected = 0.01 / (1 / 600.0 + 1 / 400.0);
  EXPECT_NEAR(length(force), expected, 1e-9 * expected);
  EXPECT_NEAR(dot(force, held), -0.01 * expected, 1e-9 * expected);  // it pushes the hand back
}

// Claim: so it does where the family tells no stiffness and tissue is stiffer than the coupling: one Gaussian
// for each axis, whose slope at rest is 0.5 e^-0.25 x 60 N / 10 mm = 2340 N/m.
TEST(HapticLoop, SettlesOnNetworksStifferThanTheCoupling) {
  Model model = small_model(9, 3);
  for (auto& node : model.nodes) {
    RbfNetwork& net = node.force;
    net.input_center.setZero();
    net.input_half_range.setConstant(0.01);
    net.output_center.setZero();
    net.output_half_range.setOnes();
    net.spread = 2;
    net.center_displacement = {1, 3, 5};  // 10 mm along x, y, z
    net.weights = 60 * Eigen::Matrix3d::Identity();
    net.bias.setConstant(-60 * std::exp(-0.25));
    fill_centers(model, net);
  }
  const LoadedModel loaded(write_model_text(model));
  ForceThread loop(settings(), loaded.model, loaded.data, 3);
  Vector3 force;
  for (long i = 1; i < 200; ++i) force = loop.step({0.004, -0.002, 0.001}, i, i);
  Touch touch;
  loop.touch().read(touch);
  const double at[] = {touch.displacement.x, touch.displacement.y, touch.displacement.z};
  double f[3];
  ASSERT_GE(phn_force(loaded.model, loaded.data, 3, at, f, nullptr, nullptr), 0);
  const double expected[] = {-f[0], -f[1], -f[2]}, said[] = {force.x, force.y, force.z};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(said[k], expected[k], 1e-9);
  EXPECT_GT(f[0], 1);  // N, of 1.6 that 4 mm of the coupling are: stiff tissue
}

// Claim: positions that stay away for more than stale_cycles switch the force off until new ones come.
TEST(HapticLoop, GivesNoForceOnStalePositions) {
  Loop loop(spring(600), settings(), 0.02);
  for (int i = 0; i < 400; ++i) loop.cycle();
  long zero = 0;
  for (int i = 0; i < 30; ++i) zero += length(loop.cycle(true)) == 0;
  EXPECT_EQ(zero, loop.loop.stale_cycles());
  // 30 cycles less those that are allowed and the two that a position takes anyway.
  EXPECT_NEAR(static_cast<double>(zero), 30.0 - static_cast<double>(settings().stale_cycles), 2);
  for (int i = 0; i < 3; ++i) loop.cycle();
  EXPECT_GT(length(loop.cycle()), 0);
}

// Claim: a soft coupling makes no energy; one so stiff that sampling, rounding and delay make some is held
// back by the controller, to less than a quarter of what there is without it.
TEST(HapticLoop, IsPassiveOrHeldBack) {
  Loop soft(spring(600), settings(), 0.02);
  for (int i = 0; i < 30'000; ++i) soft.cycle();
  EXPECT_EQ(soft.loop.most_generated(), 0);
  auto stiff = settings();
  stiff.coupling_stiffness_N_per_m = 4000;
  double generated[2];
  for (const bool controlled : {false, true}) {
    stiff.passivity_controller = controlled;
    Loop loop(spring(3000), stiff, 0.02);
    for (int i = 0; i < 30'000; ++i) loop.cycle();
    generated[controlled] = loop.loop.most_generated();
  }
  EXPECT_GT(generated[0], 1e-4);  // J: there is something to hold back
  EXPECT_LT(generated[1], generated[0] / 4);
}

/// A ball of 5 cm whose node 4 is at its top; some 50 N/m at a node times `harder`.
Model ball_of(double harder, Family family = Family::linear) {
  Model model = family == Family::modal ? bent_model(ball(2)) : linear_model(ball(2));
  for (auto& node : model.nodes) {
    node.linear.stiffness *= harder;
    node.conservative.stiffness *= harder;
    node.conservative.coefficients *= harder;
  }
  return model;
}

struct TouchingLoop {
  TouchingLoop(const Model& model, const LoopSettings& settings, double reach_m, double friction = 0, int node = 4)
      : loaded(write_model_text(model)),
        touching({0.004, friction, 0.002}, loaded.model, loaded.data, make_contact(), node),
        loop(settings, loaded.model, touching),
        device({}, HandMotion(reach_m)) {}
  phn_contact* make_contact() {
    std::size_t bytes = 0;
    LoadedModel::check(phn_contact_size(loaded.model, 1, &bytes));
    memory.resize(bytes);
    phn_contact* contact = nullptr;
    LoadedModel::check(phn_contact_init(memory.data(), bytes, loaded.model, 1, &contact));
    return contact;
  }
  Vector3 cycle() {
    const auto sample = device.read();
    const Vector3 force = loop.step(sample.position, sample.cycle, ++now);
    device.hold(force, false);
    return force;
  }
  /// The device held at a place.
  Vector3 at(Vector3 position) {
    ++now;
    return loop.step(position, now, now);
  }
  Touch touch() {
    Touch now_touched;
    loop.touch().read(now_touched);
    return now_touched;
  }
  LoadedModel loaded;
  std::vector<char> memory;
  TouchingTool touching;
  ForceThread loop;
  SimulatedDevice device;
  long now = 0;
};

// Claim: a sphere in the air is where the device is and feels nothing, to the last bit, beside the surface
// too.
TEST(TouchingLoop, FeelsNothingInTheAir) {
  TouchingLoop loop(ball_of(12), settings(), 0);
  for (const double z : {0.0, 0.02, -0.0015, 0.001}) {
    for (int i = 0; i < 20; ++i) {
      const Vector3 at{0.002 * i, -0.001 * i, z + 1e-4 * i};
      const Vector3 force = loop.at(at);
      EXPECT_EQ(length(force), 0);
      EXPECT_EQ(length(loop.touch().displacement - at), 0);
      EXPECT_EQ(loop.touch().held.nodes[0], -1);
    }
  }
  EXPECT_EQ(loop.touching.touches(), 0);
  EXPECT_EQ(loop.loop.work(), 0);
}

// Claim: pressed and held, a sphere that sticks gives the force of the node that it came down on, at the
// displacement where coupling and tissue balance; when it leaves, nothing stays. Tissue softer and stiffer
// than the coupling.
TEST(TouchingLoop, SettlesWhereCouplingAndTissueBalance) {
  for (const Family family : {Family::linear, Family::modal}) {
    for (const double harder : {1.0, 12.0, 60.0}) {
      TouchingLoop loop(ball_of(harder, family), settings(), 0, 1e6);
      Vector3 force;
      for (int i = 0; i <= 120; ++i) force = loop.at({0, 0, -1e-4 * i});
      const Vector3 position{0, 0, -0.012};
      for (int i = 0; i < 100; ++i) force = loop.at(position);
      const Touch touch = loop.touch();
      int heaviest = 0;
      for (int k = 1; k < 3; ++k)
        if (touch.held.weights[k] > touch.held.weights[heaviest]) heaviest = k;
      ASSERT_EQ(touch.held.nodes[heaviest], 4);
      ASSERT_NEAR(touch.held.weights[heaviest], 1, 1e-9);  // the way down is straight, to rounding
      double of_node[3];
      ASSERT_GE(phn_force(loop.loaded.model, loop.loaded.data, 4, touch.held.displacement, of_node, nullptr, nullptr),
                0);
      // The device's z is the body's z; its x and y are turned about it.
      // The contact's guard counts work by trapezoids, which are exact in a linear body, and cuts what they
      // miss.
      const double tolerance = (family == Family::linear ? 1e-9 : 1e-3) * length(force);
      EXPECT_NEAR(force.z, -of_node[2], tolerance);
      EXPECT_NEAR(length(force), std::hypot(of_node[0], of_node[1], of_node[2]), tolerance);
      EXPECT_GT(force.z, 0.2);
      const Vector3 balance = 400 * (touch.displacement - position) - force;
      EXPECT_LT(length(balance), 1e-9);
      for (int i = 0; i < 20; ++i) force = loop.at({0, 0, 0.001 * i});
      EXPECT_EQ(length(force), 0);
      EXPECT_EQ(loop.touching.touches(), 1);
    }
  }
}

// Claim: a hand that taps, presses and circles on a ball, with friction and without, on tissue of some 50 and
// 600 N/m, touches and leaves again and again, is pushed back, and gets no energy that it did not give.
TEST(TouchingLoop, IsPassive) {
  for (const double friction : {0.0, 0.4}) {
    for (const double harder : {1.0, 12.0}) {
      TouchingLoop loop(ball_of(harder, Family::modal), settings(), 0.015, friction);
      double largest = 0;
      for (int i = 0; i < 20'000; ++i) largest = std::max(largest, length(loop.cycle()));
      EXPECT_GE(loop.touching.touches(), 7);
      EXPECT_GT(loop.touching.cycles_in_contact(), 5'000);
      EXPECT_LT(loop.touching.cycles_in_contact(), 19'000);
      EXPECT_GT(largest, 0.1);
      EXPECT_EQ(loop.loop.most_generated(), 0) << friction << ' ' << harder;
      EXPECT_GT(loop.loop.work(), 0);
    }
  }
}

// Claim: a node that is not on the surface is named.
TEST(TouchingLoop, BeginsAboveTheSurface) {
  Model model = small_linear_model();
  EXPECT_THROW(TouchingLoop(model, settings(), 0.01, 0, 15), std::invalid_argument);
  EXPECT_NO_THROW(TouchingLoop(model, settings(), 0.01, 0, 3));
}

// Claim: the tool never leaves what was trained, whatever the hand does.
TEST(HapticLoop, KeepsTheToolWithinTheTrainedDepth) {
  Loop loop(spring(20), settings(), 0.5);
  double deepest = 0;
  for (int i = 0; i < 5'000; ++i) {
    loop.cycle();
    Touch touch;
    loop.loop.touch().read(touch);
    deepest = std::max(deepest, length(touch.displacement));
  }
  EXPECT_LE(deepest, largest_displacement_m * (1 + 1e-12));
  EXPECT_GT(deepest, 0.9 * largest_displacement_m);
  TouchingLoop touching(ball_of(1, Family::linear), settings(), 0.2);
  double pushed_in = 0;
  for (int i = 0; i < 5'000; ++i) {
    touching.cycle();
    const Touch touch = touching.touch();
    const double* p = touch.held.displacement;
    pushed_in = std::max(pushed_in, std::hypot(p[0], p[1], p[2]));
  }
  // While it slides the touched point goes a little further than the step that was cut.
  EXPECT_LE(pushed_in, 1.1 * largest_displacement_m);
  EXPECT_GT(pushed_in, 0.9 * largest_displacement_m);
}

// Claim: a cycle allocates nothing, in any family; the counter is shown to count.
TEST(HapticLoop, AllocatesNothing) {
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    Loop loop(small_model_of(family), settings(), 0.01);
    const long before = n_allocations;
    for (int i = 0; i < 1000; ++i) loop.cycle();
    EXPECT_EQ(n_allocations, before) << name(family);
    if (family == Family::rbfn) continue;  // bodies to touch are of the others
    TouchingLoop touching(ball_of(1, family), settings(), 0.02, 0.2);
    const long between = n_allocations;
    for (int i = 0; i < 3000; ++i) touching.cycle();
    EXPECT_EQ(n_allocations, between) << name(family);
    EXPECT_GT(touching.touching.cycles_in_contact(), 100) << name(family);
    delete new int;
  }
  EXPECT_GT(n_allocations, 0);
}

}  // namespace
