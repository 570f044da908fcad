// Defaults and ranges of the settings.
#include <phynness/phynness.h>

#include <cstddef>
#include <iterator>

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

enum class Range { positive, at_least_0, any, rotation };

struct Setting {
  std::size_t offset;
  int n;
  Range range;
  const char* message;
};

constexpr double largest = 1e9;  // products of the settings stay finite
#define SETTING(name, n, range, what) \
  { offsetof(phn_loop_settings, name), n, range, "The setting " #name " must be " what }
#define POSITIVE(name) SETTING(name, 1, Range::positive, "a number above 1e-9 and at most 1e9.")
#define AT_LEAST_0(name) SETTING(name, 1, Range::at_least_0, "a number from 0 to 1e9.")

/// In the order of the struct.
constexpr Setting setting_rows[] = {POSITIVE(period_s),
                                    AT_LEAST_0(position_resolution_m),
                                    SETTING(rotation, 9, Range::rotation, "a proper rotation to 1e-9."),
                                    SETTING(origin_m, 3, Range::any, "numbers from -1e9 to 1e9."),
                                    POSITIVE(motion_scale),
                                    POSITIVE(force_scale),
                                    POSITIVE(coupling_N_per_m),
                                    AT_LEAST_0(coupling_damping_Ns_per_m),
                                    AT_LEAST_0(device_damping_Ns_per_m),
                                    AT_LEAST_0(reach_m),
                                    AT_LEAST_0(largest_damping_Ns_per_m),
                                    AT_LEAST_0(least_mass_kg),
                                    AT_LEAST_0(allowance_J),
                                    AT_LEAST_0(largest_reserve_J),
                                    POSITIVE(largest_force_N),
                                    AT_LEAST_0(largest_slew_N_per_s),
                                    AT_LEAST_0(ramp_s),
                                    AT_LEAST_0(trip_energy_J),
                                    AT_LEAST_0(trip_force_N),
                                    AT_LEAST_0(trip_speed_m_per_s),
                                    AT_LEAST_0(trip_jump_m),
                                    AT_LEAST_0(trip_stale_s),
                                    AT_LEAST_0(trip_frozen_s),
                                    AT_LEAST_0(trip_overrun_s)};

bool is_in_range(const phn_loop_settings& settings, const Setting& row) {
  const auto* values = reinterpret_cast<const double*>(reinterpret_cast<const char*>(&settings) + row.offset);
  for (int i = 0; i < row.n; ++i) {
    const double v = values[i];
    if (!(std::fabs(v) <= largest)) return false;  // or it is NaN
    if (row.range == Range::positive && !(v > 1 / largest)) return false;
    if (row.range == Range::at_least_0 && v < 0) return false;
  }
  return row.range != Range::rotation || proper_rotation(values);
}

}  // namespace

int phynness::loop::status_of(const phn_loop_settings& s) {
  if ((s.reserved[0] | s.reserved[1]) != 0) return PHN_ERROR_VERSION;
  int status = PHN_ERROR_SETTING;
  for (const Setting& row : setting_rows) {
    if (!is_in_range(s, row)) return status;
    --status;
  }
  return PHN_OK;
}

const char* phynness::loop::setting_message(int status) {
  const int row = PHN_ERROR_SETTING - status;
  return row >= 0 && row < static_cast<int>(std::size(setting_rows)) ? setting_rows[row].message : nullptr;
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
