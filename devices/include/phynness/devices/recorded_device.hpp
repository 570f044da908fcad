// A recorded motion as a device. Positions are read from a file, and forces are stored for the caller. They do not
// change the motion, so that every run has the same positions.
#pragma once

#include <phynness/devices/device.hpp>

#include <array>
#include <vector>

namespace phynness::devices {

class RecordedDevice : public Device {
 public:
  /// @param file  a motion of one tool at a node (formats/motion.md), whose displacements are positions, one per
  /// period,
  ///              linear between its steps
  explicit RecordedDevice(std::string file, double period_s = 1e-3) : _file(std::move(file)), _period_s(period_s) {}

  /// @throws std::runtime_error  with the file and what is wrong
  void open() override;
  Traits traits() const override;
  double now() override { return _now; }
  bool wait() override { return _next < _samples.size(); }
  bool read(phn_loop_sample& sample) override;
  void hold(const double force[3]) override { _forces.push_back({force[0], force[1], force[2]}); }
  void close() noexcept override {}

  /// Forces of all cycles so far [N].
  const std::vector<std::array<double, 3>>& forces() const { return _forces; }

 private:
  std::string _file;
  double _period_s, _now = 0;
  std::size_t _next = 0;
  std::vector<phn_loop_sample> _samples;
  std::vector<std::array<double, 3>> _forces;
};

}  // namespace phynness::devices
