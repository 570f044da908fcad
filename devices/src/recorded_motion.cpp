#include "recorded_motion.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace phynness::devices {
namespace {

using nlohmann::json;

constexpr double most_samples = 1e7;

std::vector<phn_loop_sample> steps_of(const json& motion) {
  if (motion.at("format") != "phynness motion 1") throw std::runtime_error("its format is not \"phynness motion 1\"");
  if (motion.at("tools").size() != 1) throw std::runtime_error("it has more than one tool; record one");
  if (!motion.at("tools").at(0).contains("node")) throw std::runtime_error("its tool is not at a node; touch a node");
  const json &times = motion.at("time_s"), &displacements = motion.at("displacement_m");
  if (!times.is_array() || times.empty() || !displacements.is_array() || displacements.size() != times.size())
    throw std::runtime_error("time_s and displacement_m must have the same number of steps");
  std::vector<phn_loop_sample> steps;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto step = "step " + std::to_string(i) + ": ";
    const json& d = displacements[i].at(0);
    if (d.is_null()) throw std::runtime_error(step + "the tool lets go, which a loop cannot replay");
    if (d.size() != 3) throw std::runtime_error(step + "a displacement must be three numbers");
    steps.push_back({{d.at(0).get<double>(), d.at(1).get<double>(), d.at(2).get<double>()}, times[i].get<double>()});
    if (i > 0 && steps[i].time_s < steps[i - 1].time_s) throw std::runtime_error(step + "its time is too early");
  }
  return steps;
}

}  // namespace

std::vector<phn_loop_sample> samples_of_motion(const std::string& text, const std::string& file, double period_s) try {
  const auto steps = steps_of(json::parse(text));
  const double start_s = steps.front().time_s, n = std::floor((steps.back().time_s - start_s) / period_s + 1e-6);
  if (!(n < most_samples)) throw std::runtime_error("it is too long");
  std::vector<phn_loop_sample> samples;
  std::size_t next = 0;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(n); ++i) {
    phn_loop_sample sample{};
    sample.time_s = start_s + static_cast<double>(i) * period_s;
    while (next + 1 < steps.size() && steps[next].time_s < sample.time_s) ++next;
    const auto &a = steps[next > 0 ? next - 1 : 0], &b = steps[next];
    const double dt = b.time_s - a.time_s, s = dt > 0 ? std::fmin((sample.time_s - a.time_s) / dt, 1) : 1;
    for (int k = 0; k < 3; ++k) sample.position_m[k] = (1 - s) * a.position_m[k] + s * b.position_m[k];
    samples.push_back(sample);
  }
  return samples;
} catch (const json::exception& error) {
  throw std::runtime_error(file + ": not a motion (formats/motion.md): " + error.what());
} catch (const std::runtime_error& error) {
  throw std::runtime_error(file + ": " + error.what());
}

}  // namespace phynness::devices
