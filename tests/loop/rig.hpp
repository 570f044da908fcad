// A loop, a body and the simulated device with its true energies, cycle by cycle.
#pragma once

#include <phynness/devices/simulated_device.hpp>
#include <phynness/phynness_loop.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "../contact/bodies.hpp"

namespace phynness::test {

using devices::HandMotion;
using devices::SimulatedDevice;
using devices::SimulatedDeviceSettings;
using devices::Vector3;

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

/// A tool at a node, or, with a radius, a sphere above it.
struct Body {
  Body(const Model& model, int at_node, double radius = 0, double with_friction = 0)
      : text(write_model_text(model)),
        loaded(text),
        data(loaded, 1),
        node(at_node),
        held(loaded, data, at_node),
        sphere_radius(radius),
        friction(with_friction) {
    if (radius > 0) contact = rt::Contact(loaded, 1);
    sphere = std::make_unique<rt::TouchingSphere>(contact, data, radius, with_friction);
  }
  phn_loop_response at(const double (&tool)[3]) { return sphere_radius > 0 ? sphere->at(tool) : held.at(tool); }
  std::string text;
  rt::Model loaded;
  rt::Tools data;
  rt::Contact contact;
  int node;
  rt::HeldNode held;
  double sphere_radius, friction;
  std::unique_ptr<rt::TouchingSphere> sphere;
};

class Rig {
 public:
  /// @param change  of the settings that follow from the traits of the device
  Rig(Body& of_body, const SimulatedDeviceSettings& simulated, double reach_m,
      const std::function<void(phn_loop_settings&)>& change = {})
      : Rig(of_body, simulated, HandMotion(reach_m), change) {}
  Rig(Body& of_body, const SimulatedDeviceSettings& simulated, const std::function<Vector3(double)>& motion,
      const std::function<void(phn_loop_settings&)>& change = {})
      : Rig(of_body, simulated, HandMotion(motion), change) {}
  Rig(Body& of_body, const SimulatedDeviceSettings& simulated, const HandMotion& motion,
      const std::function<void(phn_loop_settings&)>& change)
      : device(simulated, motion), body(of_body), settings(devices::settings_for(device.traits())) {
    settings.check_force_N = 0;
    if (body.sphere_radius > 0) rt::place_above(body.loaded, body.node, body.sphere_radius + 0.002, settings).ignore();
    if (change) change(settings);
    loop = rt::Loop(settings);
    loop.engage().ignore();
  }

  Vector3 cycle() {
    phn_loop_sample sample;
    double tool[3], force[3], really[3];
    const bool arrived = device.read(sample);
    loop.read(arrived ? &sample : nullptr, device.now(), tool).ignore();
    phn_loop_response response = body.at(tool);
    if (response_fault) response_fault(response);
    loop.hold(response, device.now(), force).ignore();
    compare();
    device.hold(force);
    taken.push_back(-device.energy().delivered);
    if (device.held(really)) loop.held(really).ignore();
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
  rt::Loop loop;
  std::function<void(phn_loop_response&)> response_fault;
  std::vector<double> taken = {0};  ///< true work at the ends of the cycles [J]
  double largest_difference = 0;    ///< between observed and true work at the time of the newest sample [J]
  double largest = 0;               ///< force [N]
  long in_contact = 0;

 private:
  void compare() {
    const phn_loop_report report = loop.report();
    const double periods = (device.now() - report.latency_s) / settings.period_s;
    if (!(periods > 0)) return;
    const auto before = std::min(static_cast<std::size_t>(periods + 1e-9), taken.size() - 1);
    const auto after = std::min(before + 1, taken.size() - 1);
    const double share = std::clamp(periods - static_cast<double>(before), 0.0, 1.0);
    const double truth = (1 - share) * taken[before] + share * taken[after];
    largest_difference = std::max(largest_difference, std::fabs(truth - report.work_J));
  }
};

}  // namespace phynness::test
