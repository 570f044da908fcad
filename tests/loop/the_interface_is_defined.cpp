// Claims of phynness_loop.h that concern statuses, frames, ramps, and the coupling.
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "rig.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

double size(Vector3 a) { return std::hypot(a.x, a.y, a.z); }

/// A loop whose device stands still.
struct Still {
  explicit Still(const phn_loop_settings& settings) : loop(settings) {}
  /// @return the force after so many cycles
  template <class At>
  Vector3 at(Vector3 x, At&& response_at, int cycles) {
    const double position[3] = {x.x, x.y, x.z};
    double force[3] = {};
    for (int i = 0; i < cycles; ++i) {
      now += 1e-3;
      phn_loop_read(loop, position, now, now, tool);
      const phn_loop_response response = response_at(tool);
      phn_loop_hold(loop, &response, now, force);
    }
    return {force[0], force[1], force[2]};
  }
  Vector3 at(Vector3 x, Body& body, int cycles) {
    return at(
        x, [&](const double(&place)[3]) { return body.at(place); }, cycles);
  }
  Loop loop;
  double now = 0, tool[3] = {};
};

phn_loop_settings settings() {
  phn_loop_settings s = defaults();
  s.trip_frozen_s = 0;
  s.allowance_J = 1e3;  // a device that is put somewhere has done no work that could be returned
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
  const phn_loop_response there = body.at(still.tool);
  EXPECT_NEAR(force.x, -there.force[0], 1e-9);
  EXPECT_NEAR(force.y, -there.force[1], 1e-9);
  EXPECT_NEAR(force.z, -there.force[2], 1e-9);
  EXPECT_GT(there.force[0], 1);  // of 1.6 N that 4 mm of the coupling are
}

// Claim: a body that softens faster than the coupling is stiff does not let the tool jump: the force stays bounded and
// settles on a branch that is stable. Energy 0.5 k |d|^2 with k = -600 N/m up to 5 mm, then +600 N/m.
TEST(Coupling, StaysBoundedOnIndefiniteStiffness) {
  Still still(settings());
  double largest = 0;
  const auto softening = [](const double(&tool)[3]) {
    phn_loop_response r = {};
    r.in_contact = r.has_stiffness = 1;
    const double d = std::hypot(tool[0], tool[1], tool[2]), k = d < 0.005 ? -600 : 600;
    for (int j = 0; j < 3; ++j) {
      r.displacement[j] = tool[j];
      r.force[j] = d < 0.005 ? k * tool[j] : k * tool[j] - 1200 * 0.005 * tool[j] / d;
      r.stiffness[4 * j] = k;
    }
    return r;
  };
  for (int i = 0; i < 2'000; ++i) largest = std::max(largest, size(still.at({0.004, 0.001, 0}, softening, 1)));
  EXPECT_LT(largest, 400 * 0.02);
  EXPECT_LT(std::hypot(still.tool[0], still.tool[1], still.tool[2]), 0.02);
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

// Claim: engage raises the force over ramp_s.
TEST(Ramps, Rise) {
  Body body(spring(600), 3);
  Still still(settings());
  const Vector3 x{0.004, 0, 0};
  const double half = size(still.at(x, body, 50)), whole = size(still.at(x, body, 100));
  EXPECT_NEAR(half, 0.5 * whole, 0.03 * whole);
  EXPECT_EQ(still.loop.report().state, PHN_LOOP_ON);
}

// Claim: the tool stays within the reach, the force within its limit and its slew rate.
TEST(Limits, Hold) {
  Body body(spring(20), 3);
  Rig rig(body, {}, 0.2, [](phn_loop_settings& s) {
    s.reach_m = 0.02;
    s.largest_force_N = 3;
    s.largest_slew_N_per_s = 500;
    s.allowance_J = 1e3;
    s.trip_energy_J = s.trip_force_N = s.trip_speed_m_per_s = 0;
  });
  Vector3 last{};
  double fastest = 0;
  for (int i = 0; i < 5'000; ++i) {
    const Vector3 f = rig.cycle();
    fastest = std::max(fastest, size(f - last));
    last = f;
  }
  EXPECT_LE(rig.largest, 3 * (1 + 1e-12));
  EXPECT_GT(rig.largest, 2.9);
  EXPECT_LE(fastest, 0.5 * (1 + 1e-12));  // N per cycle
}

// Claim: settings that make no sense, null pointers and too little memory are refused with their status, and every
// setting by its name.
TEST(Interface, RefusesWhatMakesNoSense) {
  std::size_t bytes = 0;
  ASSERT_EQ(phn_loop_size(&bytes), PHN_OK);
  std::vector<char> memory(bytes + 1);
  phn_loop* loop = nullptr;
  const auto init = [&](const phn_loop_settings& s) { return phn_loop_init(memory.data(), bytes, &s, &loop); };
  EXPECT_EQ(init(defaults()), PHN_OK);
  EXPECT_EQ(phn_loop_init(memory.data(), bytes / 2, nullptr, &loop), PHN_ERROR_ARGUMENT);
  phn_loop_settings s = defaults();
  EXPECT_EQ(phn_loop_init(memory.data(), bytes / 2, &s, &loop), PHN_ERROR_BUFFER);
  EXPECT_EQ(loop, nullptr);
  EXPECT_EQ(phn_loop_init(memory.data() + 1, bytes, &s, &loop), PHN_OK);  // any alignment
  const auto refused = [&](const phn_loop_settings& wrong, const std::string& name) {
    const int status = init(wrong);
    EXPECT_EQ(loop, nullptr);
    EXPECT_LE(status, PHN_ERROR_SETTING);
    EXPECT_TRUE(std::string(phn_loop_trip_message(status)).starts_with("The setting " + name + " must be "))
        << status << ": " << phn_loop_trip_message(status);
  };
  const auto refused_values = [&](double phn_loop_settings::*member, const std::string& name, double smallest_good) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    for (const double value : {-1e-3, 2e9, nan, infinity, -infinity}) {
      s = defaults();
      s.*member = value;
      refused(s, name);
    }
    s.*member = 0;
    if (smallest_good > 0) refused(s, name);
    s.*member = smallest_good;
    EXPECT_EQ(init(s), PHN_OK) << name;
  };
#define POSITIVE(member) refused_values(&phn_loop_settings::member, #member, 1e-6)
#define AT_LEAST_0(member) refused_values(&phn_loop_settings::member, #member, 0)
  POSITIVE(period_s);
  POSITIVE(motion_scale);
  POSITIVE(force_scale);
  POSITIVE(coupling_N_per_m);
  POSITIVE(largest_force_N);
  AT_LEAST_0(position_resolution_m);
  AT_LEAST_0(coupling_damping_Ns_per_m);
  AT_LEAST_0(device_damping_Ns_per_m);
  AT_LEAST_0(reach_m);
  AT_LEAST_0(largest_damping_Ns_per_m);
  AT_LEAST_0(least_mass_kg);
  AT_LEAST_0(allowance_J);
  AT_LEAST_0(largest_reserve_J);
  AT_LEAST_0(largest_slew_N_per_s);
  AT_LEAST_0(ramp_s);
  AT_LEAST_0(trip_energy_J);
  AT_LEAST_0(trip_force_N);
  AT_LEAST_0(trip_speed_m_per_s);
  AT_LEAST_0(trip_jump_m);
  AT_LEAST_0(trip_stale_s);
  AT_LEAST_0(trip_frozen_s);
  AT_LEAST_0(trip_overrun_s);
  for (const int entry : {0, 4, 8}) {  // a reflection, and a matrix that is no rotation
    s = defaults();
    s.rotation[entry] = -1;
    refused(s, "rotation");
    s.rotation[entry] = 1.001;
    refused(s, "rotation");
  }
  s = defaults();
  s.origin_m[2] = std::numeric_limits<double>::quiet_NaN();
  refused(s, "origin_m");
  // The page: member i of the struct has the status PHN_ERROR_SETTING - i, where an array is one member.
  s = defaults();
  s.period_s = 0;
  EXPECT_EQ(init(s), PHN_ERROR_SETTING);
  s = defaults();
  s.trip_overrun_s = -1;
  EXPECT_EQ(init(s), PHN_ERROR_SETTING - 23);
  EXPECT_STREQ(phn_loop_trip_message(PHN_ERROR_SETTING - 24), "This is not a reason of a trip.");
  double three[3] = {1, 2, 3};
  EXPECT_EQ(phn_loop_read(nullptr, nullptr, 0, 0, three), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(three[0], 0);
  EXPECT_EQ(phn_loop_hold(nullptr, nullptr, 0, three), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_loop_engage(nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_loop_info(nullptr, nullptr), PHN_ERROR_ARGUMENT);
  for (int t = -1; t < 14; ++t) EXPECT_NE(phn_loop_trip_message(t), nullptr);
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
    phn_loop_settings s = defaults();
    if (random() % 3 == 0) s.motion_scale = random() % 2 != 0 ? 1e9 : 1.1e-9;
    if (random() % 3 == 0) s.position_resolution_m = 1e-5;
    if (random() % 2 == 0) s.trip_jump_m = s.trip_speed_m_per_s = s.trip_energy_J = s.trip_force_N = 0;
    Loop loop(s);
    double now = 0;
    for (int i = 0; i < 100; ++i) {
      now += random() % 10 != 0 ? 1e-3 : any();
      const bool is_plain = i < 50;  // so that there is a force
      const double position[3] = {is_plain ? 1e-4 * i : any(), is_plain ? 0 : any(), 0};
      double tool[3], force[3];
      phn_loop_read(loop, position, random() % 10 != 0 ? now : any(), now, tool);
      phn_loop_response r = {0, 1, static_cast<std::int32_t>(random() % 2), {}, {}, {}, -1};
      for (int k = 0; k < 3; ++k) {
        r.force[k] = is_plain ? 200 * tool[k] : any();
        r.stiffness[4 * k] = is_plain ? 200 : any();
        r.displacement[k] = is_plain ? tool[k] : any();
      }
      phn_loop_hold(loop, &r, now, force);
      const phn_loop_report p = loop.report();
      for (const double v : {tool[0], tool[1], tool[2], force[0], force[1], force[2], p.work_J, p.most_delivered_J,
                             p.unsure_J, p.dissipated_J, p.speed_m_per_s, p.age_s})
        ASSERT_TRUE(std::isfinite(v)) << "run " << run << " cycle " << i;
      ASSERT_LE(std::hypot(force[0], force[1], force[2]), s.largest_force_N * (1 + 1e-12));
    }
  }
}

}  // namespace
