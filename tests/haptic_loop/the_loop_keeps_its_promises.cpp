#include <gtest/gtest.h>

#include <thread>

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

// Claim: at rest against tissue the force is that of coupling and tissue in series, to the device's resolution.
TEST(HapticLoop, SettlesWhereCouplingAndTissueBalance) {
  Loop loop(spring(600), settings(), 0);
  Vector3 force;
  const Vector3 held{0.006, 0, -0.008};
  for (long i = 1; i < 200; ++i) force = loop.loop.step(held, i, i);
  const double expected = 0.01 / (1 / 600.0 + 1 / 400.0);
  EXPECT_NEAR(length(force), expected, 1e-9 * expected);
  EXPECT_NEAR(dot(force, held), -0.01 * expected, 1e-9 * expected);  // it pushes the hand back
}

// Claim: so it does where the family tells no stiffness and tissue is stiffer than the coupling: one Gaussian for each
// axis, whose slope at rest is 0.5 e^-0.25 x 60 N / 10 mm = 2340 N/m.
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
  ASSERT_GE(phn_force(loaded.model, loaded.data, 3, at, f), 0);
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

// Claim: a soft coupling makes no energy; one so stiff that sampling, rounding and delay make some is held back by the
// controller, to less than a quarter of what there is without it.
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
}

// Claim: a cycle allocates nothing, in any family; the counter is shown to count.
TEST(HapticLoop, AllocatesNothing) {
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    Loop loop(small_model_of(family), settings(), 0.01);
    const long before = n_allocations;
    for (int i = 0; i < 1000; ++i) loop.cycle();
    EXPECT_EQ(n_allocations, before) << name(family);
    delete new int;
  }
  EXPECT_GT(n_allocations, 0);
}

}  // namespace
