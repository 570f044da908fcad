// Defaults and ranges of the settings.
#include <phynness/phynness.h>

#include "loop.hpp"

using namespace phynness::loop;

namespace {

bool proper_rotation(const double* R) {
  constexpr double rounding = 1e-9;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double product = R[3 * i] * R[3 * j] + R[3 * i + 1] * R[3 * j + 1] + R[3 * i + 2] * R[3 * j + 2];
      if (!(std::fabs(product - (i == j)) <= rounding)) return false;
    }
  const double determinant =
      R[0] * (R[4] * R[8] - R[5] * R[7]) - R[1] * (R[3] * R[8] - R[5] * R[6]) + R[2] * (R[3] * R[7] - R[4] * R[6]);
  return determinant > 0;
}

}  // namespace

int phynness::loop::status_of(const phn_loop_settings& s) {
  if ((s.reserved[0] | s.reserved[1]) != 0) return PHN_ERROR_VERSION;
  const double positive[] = {s.period_s, s.motion_scale, s.force_scale, s.coupling_N_per_m, s.largest_force_N};
  const double at_least_0[] = {s.position_resolution_m,
                               s.coupling_damping_Ns_per_m,
                               s.device_damping_Ns_per_m,
                               s.reach_m,
                               s.largest_damping_Ns_per_m,
                               s.least_mass_kg,
                               s.allowance_J,
                               s.largest_reserve_J,
                               s.largest_slew_N_per_s,
                               s.ramp_s,
                               s.trip_energy_J,
                               s.trip_force_N,
                               s.trip_speed_m_per_s,
                               s.trip_jump_m,
                               s.trip_stale_s,
                               s.trip_frozen_s,
                               s.trip_overrun_s};
  constexpr double largest = 1e9;  // products of the settings stay finite
  for (const double v : positive) {
    if (!std::isfinite(v)) return PHN_ERROR_NOT_FINITE;
    if (!(v > 1 / largest) || v > largest) return PHN_ERROR_ARGUMENT;
  }
  for (const double v : at_least_0) {
    if (!std::isfinite(v)) return PHN_ERROR_NOT_FINITE;
    if (v < 0 || v > largest) return PHN_ERROR_ARGUMENT;
  }
  if (!is_finite(vector_at(s.origin_m))) return PHN_ERROR_NOT_FINITE;
  for (const double x : s.origin_m)
    if (std::fabs(x) > largest) return PHN_ERROR_ARGUMENT;
  for (const double v : s.rotation)
    if (!std::isfinite(v)) return PHN_ERROR_NOT_FINITE;
  return proper_rotation(s.rotation) ? PHN_OK : PHN_ERROR_ARGUMENT;
}

extern "C" int phn_loop_defaults(phn_loop_settings* settings) {
  if (settings == nullptr) return PHN_ERROR_ARGUMENT;
  phn_loop_settings s = {};
  s.period_s = 1e-3;
  s.rotation[0] = s.rotation[4] = s.rotation[8] = 1;
  s.motion_scale = s.force_scale = 1;
  s.coupling_N_per_m = 400;
  s.coupling_damping_Ns_per_m = 0.2;
  s.largest_damping_Ns_per_m = 2;
  s.least_mass_kg = 0.05;
  s.allowance_J = 2e-5;
  s.largest_reserve_J = 5e-4;
  s.largest_force_N = 8;
  s.largest_slew_N_per_s = 4000;
  s.ramp_s = 0.1;
  s.trip_energy_J = 3e-4;
  s.trip_force_N = 40;
  s.trip_speed_m_per_s = 2;
  s.trip_jump_m = 0.01;
  s.trip_stale_s = 0.01;
  s.trip_frozen_s = 0.05;
  s.trip_overrun_s = 0.02;
  *settings = s;
  return PHN_OK;
}
