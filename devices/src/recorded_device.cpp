#include <phynness/devices/recorded_device.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "recorded_motion.hpp"

namespace phynness::devices {

void RecordedDevice::open() {
  std::ifstream in(_file);
  if (!in) throw std::runtime_error(_file + ": the recorded motion cannot be read; check the path");
  _samples.clear();
  _forces.clear();
  _next = 0;
  if (in.peek() == '{') {
#ifdef PHYNNESS_DEVICES_READ_MOTIONS
    std::ostringstream text;
    text << in.rdbuf();
    _samples = samples_of_motion(text.str(), _file, _period_s);
    _now = _samples.front().time_s;
    return;
#else
    throw std::runtime_error(_file +
                             ": a motion in JSON needs nlohmann/json.hpp (Debian: nlohmann-json3-dev) where the "
                             "devices are built; or write lines x y z");
#endif
  }
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<double> v;
    for (double x; words >> x;) v.push_back(x);
    const auto where = _file + ":" + std::to_string(number) + ": ";
    const bool all_finite = std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
    if (!words.eof() || (v.size() != 3 && v.size() != 4) || !all_finite)
      throw std::runtime_error(where + "not three or four finite numbers: " + line + "; write x y z or t x y z");
    const double time = v.size() == 4 ? v[0] : _samples.empty() ? _period_s : _samples.back().time_s + _period_s;
    if (!_samples.empty() && !(time > _samples.back().time_s))
      throw std::runtime_error(where + "the time " + std::to_string(time) + " is not later than the one before");
    const auto n = v.size();
    _samples.push_back({{v[n - 3], v[n - 2], v[n - 1]}, time});
  }
  if (_samples.empty()) throw std::runtime_error(_file + ": no line has a position; write x y z or t x y z");
  _now = _samples.front().time_s;
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
