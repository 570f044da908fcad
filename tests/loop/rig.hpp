// A loop, a body and a simulated device with its true energies, cycle by cycle.
#pragma once

#include <phynness/phynness_loop.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <phynness/phynness.hpp>
#include <string>
#include <vector>

#include "../contact/bodies.hpp"
#include "simulated_device.hpp"

namespace phynness::test {

inline phn_loop_settings defaults() {
  phn_loop_settings settings;
  phn_loop_defaults(&settings);
  return settings;
}

/// A loop in memory of its own, engaged.
class Loop {
 public:
  explicit Loop(const phn_loop_settings& settings) {
    std::size_t bytes = 0;
    phn_loop_size(&bytes);
    _memory.resize(bytes);
    phn_loop_init(_memory.data(), bytes, &settings, &_loop);
    phn_loop_engage(_loop);
  }
  operator phn_loop*() { return _loop; }
  phn_loop_report report() const {
    phn_loop_report report = {};
    phn_loop_info(_loop, &report);
    return report;
  }
  std::string why() const { return phn_loop_trip_message(report().trip); }

 private:
  std::vector<char> _memory;
  phn_loop* _loop = nullptr;
};

/// Every fifth of all combinations of factors, in the order of nested loops. Where no inner number of combinations is a
/// multiple of five, each value of a factor meets most values of each other one.
struct EveryFifth {
  bool skips() { return number++ % 5 != 0; }
  int number = 0;
};

/// Tissue of one stiffness at node 3 [N/m].
inline Model spring(double stiffness) {
  Model model = small_model_of(Family::linear);
  for (auto& node : model.nodes) node.linear.stiffness = stiffness * Eigen::Matrix3d::Identity();
  return model;
}

/// A ball of 5 cm whose node 4 is at its top; some 50 N/m at a node times `harder`.
inline Model ball_of(double harder, Family family = Family::linear) {
  Model model = family == Family::modal ? bent_model(ball(2)) : linear_model(ball(2));
  for (auto& node : model.nodes) {
    node.linear.stiffness *= harder;
    node.conservative.stiffness *= harder;
    node.conservative.coefficients *= harder;
  }
  return model;
}

/// A tool at a node, or, with a radius, a sphere.
struct Body {
  Body(const Model& model, int at_node, double radius = 0, double friction = 0)
      : organ(write_model_text(model)), node(at_node), sphere{{}, radius, friction, PHN_TOOL_PRESS} {}
  phn_loop_response at(const double (&tool)[3]) {
    phn_loop_response r = {};
    if (sphere.radius > 0) {
      std::copy_n(tool, 3, sphere.center);
      OrganReport report;
      r.status = organ.touch({&sphere, 1}, {&state, 1}, &report);
      r.in_contact = state.in_contact;
      r.energy = report.energy_J;
      std::copy_n(state.force, 3, r.force);
      std::copy_n(state.held.displacement, 3, r.displacement);
      return r;
    }
    const bool energy = organ.info().has_energy != 0;
    const phn_tool held = phn_tool_at(node, tool);
    r.in_contact = 1;
    r.has_stiffness = energy;
    r.energy = -1;
    std::copy_n(tool, 3, r.displacement);
    r.status = energy ? organ.hold(held, r.force, r.energy, r.stiffness) : organ.hold(held, r.force);
    return r;
  }
  Organ organ;
  int node;
  phn_contact_tool sphere;
  phn_contact_state state = {};
};

class Rig {
 public:
  using Change = std::function<void(phn_loop_settings&)>;
  Rig(Body& of_body, const DeviceSettings& simulated, const HandMotion& motion, const Change& change = {})
      : device(simulated, motion), body(of_body), settings(set(of_body, simulated, change)), loop(settings) {}
  Rig(Body& of_body, const DeviceSettings& simulated, double reach_m, const Change& change = {})
      : Rig(of_body, simulated, busy_hand(reach_m), change) {}

  Vector3 cycle() {
    SimulatedDevice::Sample sample;
    double tool[3], force[3];
    const bool arrived = device.read(sample);
    phn_loop_read(loop, arrived ? sample.position : nullptr, sample.time_s + time_error_s, device.now(), tool);
    phn_loop_response response = body.at(tool);
    if (response_fault) response_fault(response);
    phn_loop_hold(loop, &response, device.now(), force);
    compare();
    device.hold({force[0], force[1], force[2]});
    taken.push_back(-device.energy().delivered);
    in_contact += response.in_contact;
    largest = std::max(largest, std::hypot(force[0], force[1], force[2]));
    return {force[0], force[1], force[2]};
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) cycle();
  }
  /// Until the loop trips. @return cycles, or -1
  int run_until_trip(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      cycle();
      if (loop.report().state == PHN_LOOP_TRIPPED) return i;
    }
    return -1;
  }

  SimulatedDevice device;
  Body& body;
  phn_loop_settings settings;
  Loop loop;
  std::function<void(phn_loop_response&)> response_fault;
  double time_error_s = 0;          ///< of the times of positions
  std::vector<double> taken = {0};  ///< true work at the ends of the cycles [J]
  double largest_difference = 0;    ///< between observed and true work at the time of the newest sample [J]
  double largest = 0;               ///< force [N]
  long in_contact = 0;

 private:
  static phn_loop_settings set(const Body& body, const DeviceSettings& simulated, const Change& change) {
    phn_loop_settings s = defaults();
    s.position_resolution_m = simulated.resolution_m;
    if (body.sphere.radius > 0) s.origin_m[2] = 0.05 + body.sphere.radius + 0.002;  // above the top of the ball
    if (change) change(s);
    return s;
  }
  void compare() {
    const phn_loop_report report = loop.report();
    const double periods = (device.now() - report.age_s) / settings.period_s;
    if (!(periods > 0)) return;
    const auto before = std::min(static_cast<std::size_t>(periods + 1e-9), taken.size() - 1);
    const auto after = std::min(before + 1, taken.size() - 1);
    const double share = std::clamp(periods - static_cast<double>(before), 0.0, 1.0);
    const double truth = (1 - share) * taken[before] + share * taken[after];
    largest_difference = std::max(largest_difference, std::fabs(truth - report.work_J));
  }
};

}  // namespace phynness::test
