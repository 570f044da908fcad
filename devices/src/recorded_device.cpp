#include <phynness/devices/recorded_device.hpp>

#include <cmath>
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/motion.hpp>

namespace phynness::devices {
namespace {

constexpr double most_samples = 1e7;

/// Displacements of the only tool with their times. @throws std::runtime_error
std::vector<phn_loop_sample> steps_of(const Motion& motion, const std::string& file) {
  if (motion.tools.size() != 1 || motion.tools[0].weights[0] != 1)
    throw input_error(file + ": a loop replays one tool at a node", "", "record such a motion");
  std::vector<phn_loop_sample> steps;
  for (std::size_t i = 0; i < motion.time_s.size(); ++i) {
    const auto& d = motion.displacement_m[i][0];
    if (!d)
      throw input_error(file + ": step " + std::to_string(i) + ": the tool lets go, which a loop cannot replay", "",
                        "record a motion in which the tool is held");
    steps.push_back({{(*d)[0], (*d)[1], (*d)[2]}, motion.time_s[i]});
  }
  return steps;
}

}  // namespace

void RecordedDevice::open() {
  std::string text(Motion::most_bytes + 1, '\0');
  std::ifstream in(_file);
  in.read(text.data(), std::ssize(text));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.empty()) throw std::runtime_error(_file + ": the recorded motion cannot be read; check the path");
  if (text.size() > Motion::most_bytes)
    throw input_error(_file + ": the motion has more than 32 MiB", "", "record a shorter one");
  const auto steps = steps_of(read_motion_text(text, _file), _file);
  const double start_s = steps.front().time_s, n = std::floor((steps.back().time_s - start_s) / _period_s + 1e-6);
  if (!(n < most_samples)) throw input_error(_file + ": the motion is too long", "", "record a shorter one");
  _samples.clear();
  _forces.clear();
  _next = 0;
  std::size_t next = 0;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(n); ++i) {
    phn_loop_sample sample{};
    sample.time_s = start_s + static_cast<double>(i) * _period_s;
    while (next + 1 < steps.size() && steps[next].time_s < sample.time_s) ++next;
    const auto &a = steps[next > 0 ? next - 1 : 0], &b = steps[next];
    const double dt = b.time_s - a.time_s, s = dt > 0 ? std::fmin((sample.time_s - a.time_s) / dt, 1) : 1;
    for (int k = 0; k < 3; ++k) sample.position_m[k] = (1 - s) * a.position_m[k] + s * b.position_m[k];
    _samples.push_back(sample);
  }
  _now = start_s;
}

Traits RecordedDevice::traits() const {
  Traits t;
  t.name = _file;
  t.period_s = _period_s;
  t.has_times = true;
  return t;
}

bool RecordedDevice::read(phn_loop_sample& sample) {
  if (_next >= _samples.size()) return false;
  sample = _samples[_next++];
  _now = sample.time_s;
  return true;
}

}  // namespace phynness::devices
