// Claims of phynness_loop.h that concern statuses, frames, ramps, the coupling, and memory.
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <thread>

#include <phynness/devices/latest.hpp>
#include <phynness/devices/recorded_device.hpp>

#include "rig.hpp"

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

double size(Vector3 a) { return std::hypot(a.x, a.y, a.z); }

/// A loop whose device stands still.
struct Still {
  explicit Still(const phn_loop_settings& settings) : loop(settings) { loop.engage().ignore(); }
  /// @return the force after so many cycles
  Vector3 at(Vector3 position, Body& body, int cycles) {
    double tool[3], force[3] = {};
    for (int i = 0; i < cycles; ++i) {
      now += 1e-3;
      const phn_loop_sample sample = {{position.x, position.y, position.z}, now};
      loop.read(&sample, now, tool).ignore();
      loop.hold(body.at(tool), now, force).ignore();
    }
    for (int k = 0; k < 3; ++k) last_tool[k] = tool[k];
    return {force[0], force[1], force[2]};
  }
  rt::Loop loop;
  double now = 0, last_tool[3] = {};
};

phn_loop_settings settings() {
  phn_loop_settings s = rt::loop_defaults();
  s.has_times = 1;
  s.check_force_N = 0;
  s.trip_frozen_s = 0;
  s.passivity_controller = 0;  // a device that is put somewhere has done no work that could be returned
  return s;
}

// Claim: at rest against tissue the force is that of coupling and tissue in series.
TEST(Coupling, SettlesWhereItBalancesTheTissue) {
  for (const double stiffness : {20.0, 600.0, 20'000.0}) {
    Body body(spring(stiffness), 3);
    Still still(settings());
    const Vector3 force = still.at({0.006, 0, -0.008}, body, 400);
    const double expected = 0.01 / (1 / stiffness + 1 / 400.0);
    EXPECT_NEAR(size(force), expected, 1e-9 * expected);
    EXPECT_NEAR(force.x * 0.006 - force.z * 0.008, -0.01 * expected, 1e-9 * expected);  // it pushes the hand back
  }
}

// Claim: so it does where the family has no stiffness and the tissue is stiffer than the coupling: one Gaussian for
// each axis, whose slope at rest is 0.5 e^-0.25 x 60 N / 10 mm = 2340 N/m.
TEST(Coupling, SettlesOnNetworksStifferThanItself) {
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
  Body body(model, 3);
  Still still(settings());
  const Vector3 force = still.at({0.004, -0.002, 0.001}, body, 600);
  const phn_loop_response there = body.at(still.last_tool);
  EXPECT_NEAR(force.x, -there.force[0], 1e-9);
  EXPECT_NEAR(force.y, -there.force[1], 1e-9);
  EXPECT_NEAR(force.z, -there.force[2], 1e-9);
  EXPECT_GT(there.force[0], 1);  // of 1.6 N that 4 mm of the coupling are
}

// Claim: a body that softens faster than the coupling is stiff does not let the tool jump: the force stays bounded and
// settles on a branch that is stable. Energy 0.5 k |d|^2 with k = -600 N/m up to 5 mm, then +600 N/m.
TEST(Coupling, StaysBoundedOnIndefiniteStiffness) {
  Still still(settings());
  double tool[3], force[3] = {};
  double largest = 0;
  for (int i = 0; i < 2'000; ++i) {
    still.now += 1e-3;
    const phn_loop_sample sample = {{0.004, 0.001, 0}, still.now};
    still.loop.read(&sample, still.now, tool).ignore();
    phn_loop_response r = {};
    r.in_contact = r.has_stiffness = 1;
    const double d = std::hypot(tool[0], tool[1], tool[2]), k = d < 0.005 ? -600 : 600;
    for (int j = 0; j < 3; ++j) {
      r.displacement[j] = tool[j];
      r.force[j] = d < 0.005 ? k * tool[j] : k * tool[j] - 1200 * 0.005 * tool[j] / d;
      r.stiffness[4 * j] = k;
    }
    still.loop.hold(r, still.now, force).ignore();
    largest = std::max(largest, std::hypot(force[0], force[1], force[2]));
  }
  EXPECT_LT(largest, 400 * 0.02);
  EXPECT_LT(std::hypot(tool[0], tool[1], tool[2]), 0.02);
}

// Claim: rotation and scales do what the header says: the same motion seen in another frame gives the same force.
TEST(Frames, TurnAndScale) {
  const double c = std::cos(0.7), s = std::sin(0.7), motion = 2.5, scale = 0.4;
  Body body(spring(600), 3);
  phn_loop_settings turned = settings();
  const double R[9] = {c, -s, 0, s, c, 0, 0, 0, 1}, origin[3] = {0.001, -0.002, 0.0005};
  std::copy(R, R + 9, turned.rotation);
  std::copy(origin, origin + 3, turned.origin_m);
  turned.motion_scale = motion;
  turned.force_scale = scale;
  Still still(turned);
  const Vector3 x{0.002, 0.001, -0.001}, force = still.at(x, body, 400);
  // In the frame of the body: coupling of 400 / (motion scale), tissue of 600 N/m, in series.
  const double place[3] = {origin[0] + motion * (c * x.x - s * x.y), origin[1] + motion * (s * x.x + c * x.y),
                           origin[2] + motion * x.z};
  const double series = 1 / (1 / 600.0 + scale * motion / 400.0);
  const double of_body[3] = {-series * place[0], -series * place[1], -series * place[2]};
  EXPECT_NEAR(force.x, scale * (c * of_body[0] + s * of_body[1]), 1e-12);
  EXPECT_NEAR(force.y, scale * (-s * of_body[0] + c * of_body[1]), 1e-12);
  EXPECT_NEAR(force.z, scale * of_body[2], 1e-12);
}

// Claim: engage raises the force over engage_s, release lowers it over release_s and switches off, the clutch lets the
// device move without force and goes on where it was.
TEST(Ramps, RiseFallAndClutch) {
  Body body(spring(600), 3);
  phn_loop_settings s = settings();
  Still still(s);
  const Vector3 x{0.004, 0, 0};
  const double half = size(still.at(x, body, 51)), whole = size(still.at(x, body, 100));
  EXPECT_NEAR(half, 0.5 * whole, 0.03 * whole);
  EXPECT_EQ(still.loop.report().state, PHN_LOOP_ON);
  still.loop.clutch(true).ignore();
  EXPECT_GT(size(still.at(x, body, 50)), 0.4 * whole);
  EXPECT_EQ(size(still.at(x, body, 60)), 0);
  const Vector3 elsewhere{-0.003, 0.002, 0.005};
  for (int i = 1; i <= 100; ++i)
    EXPECT_EQ(
        size(still.at({x.x + 0.01 * i * (elsewhere.x - x.x), 0.01 * i * elsewhere.y, 0.01 * i * elsewhere.z}, body, 1)),
        0);
  still.loop.clutch(false).ignore();
  const Vector3 again = still.at(elsewhere, body, 300);
  EXPECT_NEAR(again.x, -whole, 1e-6);  // as where the clutch was switched on
  EXPECT_NEAR(again.y, 0, 1e-6);
  still.loop.release().ignore();
  still.at(elsewhere, body, 60);
  EXPECT_EQ(still.loop.report().state, PHN_LOOP_RELEASING);
  EXPECT_EQ(size(still.at(elsewhere, body, 60)), 0);
  EXPECT_EQ(still.loop.report().state, PHN_LOOP_OFF);
}

// Claim: the tool stays within the reach, the force within its limit and its slew rate, and a rounded force is a
// multiple of the step.
TEST(Limits, Hold) {
  Body body(spring(20), 3);
  SimulatedDeviceSettings device;
  device.force_resolution_N = 0.01;
  Rig rig(body, device, 0.2, [](phn_loop_settings& s) {
    s.reach_m = 0.02;
    s.largest_force_N = 3;
    s.largest_slew_N_per_s = 500;
    s.passivity_controller = 0;
    s.trip_energy_J = s.trip_force_N = s.trip_speed_m_per_s = 0;
  });
  Vector3 last{};
  double fastest = 0;
  for (int i = 0; i < 5'000; ++i) {
    const Vector3 f = rig.cycle();
    fastest = std::max(fastest, std::hypot(f.x - last.x, f.y - last.y, f.z - last.z));
    last = f;
    EXPECT_NEAR(std::remainder(f.x, 0.01), 0, 1e-12);
  }
  EXPECT_LE(rig.largest, 3 * (1 + 1e-12));
  EXPECT_GT(rig.largest, 2.9);
  EXPECT_LE(fastest, 0.5 + 0.02);  // N per cycle; rounding adds up to a step on each axis
}

// Claim: settings that make no sense, null pointers and too little memory are refused with their status.
TEST(Interface, RefusesWhatMakesNoSense) {
  std::size_t bytes = 0;
  ASSERT_EQ(phn_loop_size(&bytes), PHN_OK);
  std::vector<char> memory(bytes + 1);
  phn_loop* loop = nullptr;
  const auto init = [&](const phn_loop_settings& s) { return phn_loop_init(memory.data(), bytes, &s, &loop); };
  EXPECT_EQ(init(rt::loop_defaults()), PHN_OK);
  EXPECT_EQ(phn_loop_init(memory.data(), bytes / 2, nullptr, &loop), PHN_ERROR_ARGUMENT);
  phn_loop_settings s = rt::loop_defaults();
  EXPECT_EQ(phn_loop_init(memory.data(), bytes / 2, &s, &loop), PHN_ERROR_BUFFER);
  EXPECT_EQ(loop, nullptr);
  EXPECT_EQ(phn_loop_init(memory.data() + 1, bytes, &s, &loop), PHN_OK);  // any alignment
  const auto refused = [&](double phn_loop_settings::*member, double value, int status) {
    phn_loop_settings wrong = rt::loop_defaults();
    wrong.*member = value;
    EXPECT_EQ(init(wrong), status);
    EXPECT_EQ(loop, nullptr);
  };
  for (const auto member :
       {&phn_loop_settings::period_s, &phn_loop_settings::motion_scale, &phn_loop_settings::force_scale,
        &phn_loop_settings::coupling_N_per_m, &phn_loop_settings::largest_force_N}) {
    refused(member, 0, PHN_ERROR_ARGUMENT);
    refused(member, std::numeric_limits<double>::infinity(), PHN_ERROR_NOT_FINITE);
  }
  refused(&phn_loop_settings::trip_ramp_s, -1e-3, PHN_ERROR_ARGUMENT);
  refused(&phn_loop_settings::latency_s, std::numeric_limits<double>::quiet_NaN(), PHN_ERROR_NOT_FINITE);
  for (const int entry : {0, 4, 8}) {  // a reflection, and a matrix that is no rotation
    phn_loop_settings wrong = rt::loop_defaults();
    wrong.rotation[entry] = -1;
    EXPECT_EQ(init(wrong), PHN_ERROR_ARGUMENT);
    wrong.rotation[entry] = 1.001;
    EXPECT_EQ(init(wrong), PHN_ERROR_ARGUMENT);
  }
  double three[3] = {1, 2, 3};
  EXPECT_EQ(phn_loop_read(nullptr, nullptr, 0, three), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(three[0], 0);
  EXPECT_EQ(phn_loop_hold(nullptr, nullptr, 0, three), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_loop_engage(nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_loop_get_report(nullptr, nullptr), PHN_ERROR_ARGUMENT);
  for (int t = -1; t < 14; ++t) EXPECT_NE(phn_loop_trip_message(t), nullptr);
}

// Claim: whatever bytes come in, what goes out is finite.
TEST(Interface, OutputsAreFiniteForEveryInput) {
  const double odd[] = {
      0,   1e-320, -1e300, 1e308, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(),
      3e-3};
  Numbers numbers;
  for (int run = 0; run < 200; ++run) {
    phn_loop_settings s = settings();
    s.check_force_N = run % 2 == 0 ? 0 : 0.4;
    s.trip_jump_m = s.trip_speed_m_per_s = s.trip_energy_J = s.trip_force_N = 0;
    rt::Loop loop(s);
    loop.engage().ignore();
    double now = 0;
    const auto any = [&] { return odd[static_cast<std::size_t>((numbers.next() + 1) * 3.49)]; };
    for (int i = 0; i < 60; ++i) {
      now += 1e-3;
      double tool[3], force[3];
      phn_loop_sample sample = {{1e-3 * i, 0, 0}, now};
      if (i > 20 && i % 5 == run % 5) sample.position_m[i % 3] = any();
      loop.read(&sample, now, tool).ignore();
      phn_loop_response r = {};
      r.in_contact = 1;
      r.has_stiffness = i % 2;
      for (double& f : r.force) f = i > 10 ? any() : 1;
      for (double& k : r.stiffness) k = i > 10 ? any() : 0;
      r.energy = any();
      loop.hold(r, now, force).ignore();
      const phn_loop_report report = loop.report();
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(std::isfinite(tool[k])) << run << ' ' << i;
        EXPECT_TRUE(std::isfinite(force[k])) << run << ' ' << i;
      }
      EXPECT_TRUE(std::isfinite(report.work_J + report.gross_J + report.unsure_J + report.dissipated_J));
    }
  }
}

// Claim: a cycle allocates nothing; the counter is shown to count.
TEST(Interface, AllocatesNothing) {
  for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
    Body body(small_model_of(family), 3);
    Still still(settings());
    still.at({0.001, 0, 0}, body, 10);
    const long before = n_allocations;
    still.at({0.002, 0.001, 0}, body, 1'000);
    EXPECT_EQ(n_allocations, before) << name(family);
    int* volatile counted = new int;
    delete counted;
    EXPECT_GT(n_allocations, before);
  }
}

// Claim: what the reader gets is whole and never older than what it got before, however fast the writer is.
TEST(Latest, IsWholeAndNeverGoesBack) {
  struct Value {
    long first = 0, copies[30] = {};
  };
  devices::Latest<Value> latest;
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

// Claim: whatever device, body and caller give, tool, force and report are finite, and the force is within its limit.
TEST(Limits, KeepEveryOutputFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  const double absurd[] = {0,     -0.0,    5e-324,   1e-300, 1e-9,     1e3,      1e12,
                           1e300, 1.7e308, -1.7e308, nan,    infinity, -infinity};
  std::mt19937 random(7);
  const auto any = [&] {
    return random() % 4 != 0 ? std::uniform_real_distribution<double>(-0.02, 0.02)(random)
                             : absurd[random() % std::size(absurd)];
  };
  for (int run = 0; run < 2'000; ++run) {
    phn_loop_settings s = rt::loop_defaults();
    s.has_times = static_cast<std::int32_t>(random() % 2);
    if (random() % 2 != 0) s.check_force_N = 0;
    if (random() % 3 == 0) s.motion_scale = random() % 2 != 0 ? 1e9 : 1.1e-9;
    if (random() % 3 == 0) s.position_resolution_m = 1e-5;
    rt::Loop loop(s);
    loop.engage().ignore();
    double now = 0;
    for (int i = 0; i < 100; ++i) {
      now += random() % 10 != 0 ? 1e-3 : any();
      const bool is_plain = i < 50;  // so that there is a force
      const phn_loop_sample sample = {{is_plain ? 1e-4 * i : any(), is_plain ? 0 : any(), 0},
                                      random() % 10 != 0 ? now : any()};
      double tool[3], force[3];
      loop.read(&sample, now, tool).ignore();
      phn_loop_response r = {0, 1, 1, {}, {}, {}, -1};
      for (int k = 0; k < 3; ++k) {
        r.force[k] = is_plain ? 200 * tool[k] : any();
        r.stiffness[4 * k] = is_plain ? 200 : any();
        r.displacement[k] = is_plain ? tool[k] : any();
      }
      loop.hold(r, now, force).ignore();
      const double held[3] = {any(), any(), any()};
      if (random() % 10 == 0) loop.held(held).ignore();
      const phn_loop_report p = loop.report();
      for (const double v : {tool[0], tool[1], tool[2], force[0], force[1], force[2], p.work_J, p.most_delivered_J,
                             p.gross_J, p.unsure_J, p.dissipated_J, p.speed_m_per_s, p.latency_s})
        ASSERT_TRUE(std::isfinite(v)) << "run " << run << " cycle " << i;
      ASSERT_LE(std::hypot(force[0], force[1], force[2]), s.largest_force_N * (1 + 1e-12));
    }
  }
}

}  // namespace
