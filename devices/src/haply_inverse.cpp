#include <phynness/devices/haply_inverse.hpp>

#include "haply_link.hpp"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace phynness::devices {

namespace {

void require(bool is_right, const char* name, double value, const char* range) {
  if (is_right) return;
  std::ostringstream text;
  text << "Haply Inverse service: " << name << " is " << value << "; set it to " << range;
  throw std::runtime_error(text.str());
}

void check(const HaplyInverseSettings& s) {
  if (s.host.empty()) throw std::runtime_error("Haply Inverse service: host is empty; set it to localhost");
  if (s.force_name.empty())
    throw std::runtime_error(
        "Haply Inverse service: force_name is empty; set it to vector, or values before service 3.5");
  require(s.port > 0, "port", s.port, "a port, usually 10001");
  require(s.period_s > 0 && s.period_s <= 1, "period_s", s.period_s, "more than 0 and at most 1");
  require(s.timeout_s > 0 && s.timeout_s <= 60, "timeout_s", s.timeout_s, "more than 0 and at most 60");
  require(s.hold_timeout_s > 0 && s.hold_timeout_s <= 1, "hold_timeout_s", s.hold_timeout_s,
          "more than 0 and at most 1");
  require(s.answer_timeout_s > 0 && s.answer_timeout_s <= 1, "answer_timeout_s", s.answer_timeout_s,
          "more than 0 and at most 1");
  require(s.largest_force_N > 0 && s.largest_force_N <= 20, "largest_force_N", s.largest_force_N,
          "more than 0 and at most 20");
  require(s.position_age_s >= 0 && s.position_age_s <= 0.1, "position_age_s", s.position_age_s,
          "a number from 0 to 0.1");
  require(s.force_delay_s >= 0 && s.force_delay_s <= 0.1, "force_delay_s", s.force_delay_s, "a number from 0 to 0.1");
  require(s.position_resolution_m >= 0 && s.position_resolution_m <= 0.01, "position_resolution_m",
          s.position_resolution_m, "a number from 0 to 0.01");
}

}  // namespace

HaplyInverse::HaplyInverse(HaplyInverseSettings settings) : _settings(std::move(settings)) {}

HaplyInverse::~HaplyInverse() { close(); }

void HaplyInverse::open() {
  check(_settings);
  close();
  _link = std::make_unique<Link>(_settings);
  _link->start();
  _is_open = true;
  _next = now();
}

Traits HaplyInverse::traits() const {
  Traits t;
  t.name = "Haply Inverse3";
  t.period_s = _settings.period_s;
  t.has_times = true;
  t.latency_s = _settings.position_age_s;
  t.force_delay_s = _settings.force_delay_s;
  t.position_resolution_m = _settings.position_resolution_m;
  t.largest_force_N = _settings.largest_force_N;
  return t;
}

double HaplyInverse::now() { return Link::now(); }

bool HaplyInverse::wait() {
  if (!_is_open || _link->is_lost()) return false;
  _next += _settings.period_s;
  const double time = now();
  if (_next < time - 10 * _settings.period_s) _next = time;  // what was missed is not made up for
  if (_next > time) std::this_thread::sleep_for(std::chrono::duration<double>(_next - time));
  return !_link->is_lost();
}

bool HaplyInverse::read(phn_loop_sample& sample) {
  phn_loop_sample newest{};
  if (!_is_open || _link->is_lost() || !_link->read(newest)) return false;
  sample = newest;
  return true;
}

void HaplyInverse::hold(const double force[3]) {
  const double size = std::hypot(force[0], force[1], force[2]);
  const double share = !std::isfinite(size)               ? 0
                       : size > _settings.largest_force_N ? _settings.largest_force_N / size
                                                          : 1;
  double(&newest)[3] = _recent[_n_holds++ % n_recent];
  for (int i = 0; i < 3; ++i) newest[i] = _held[i] = share > 0 ? share * force[i] : 0;
  if (_is_open && !_link->is_lost()) _link->hold({_held[0], _held[1], _held[2]});
}

bool HaplyInverse::held(double force[3]) {
  for (int i = 0; i < 3; ++i) force[i] = _held[i];
  double reported[3];
  if (_is_open && reported_force(reported) && !was_commanded(reported))
    for (int i = 0; i < 3; ++i) force[i] = reported[i];
  return _is_open && !_link->is_lost();
}

/// A report is some messages late, so that it is compared with all recent forces.
bool HaplyInverse::was_commanded(const double (&reported)[3]) const {
  const double size = std::hypot(reported[0], reported[1], reported[2]);
  for (const auto& f : _recent)
    if (std::hypot(reported[0] - f[0], reported[1] - f[1], reported[2] - f[2]) <= 1e-3 + 0.01 * size) return true;
  return size == 0;
}

void HaplyInverse::close() noexcept {
  _is_open = false;
  if (_link) _link->stop();
  for (double& f : _held) f = 0;
  for (auto& force : _recent)
    for (double& f : force) f = 0;
}

std::string HaplyInverse::lost() const { return _link ? _link->lost() : ""; }

HaplyInverseCounts HaplyInverse::counts() const { return _link ? _link->counts() : HaplyInverseCounts{}; }

bool HaplyInverse::reported_force(double force[3]) {
  haply::Force newest{};
  if (!_link || !_link->reported_force(newest)) return false;
  for (std::size_t i = 0; i < 3; ++i) force[i] = newest[i];
  return true;
}

}  // namespace phynness::devices
