#include <phynness/devices/device.hpp>

namespace phynness::devices {

phn_loop_settings settings_for(const Traits& traits) {
  phn_loop_settings s;
  phn_loop_defaults(&s);
  s.period_s = traits.period_s;
  s.has_times = traits.has_times ? 1 : 0;
  s.latency_s = traits.latency_s;
  s.force_delay_s = traits.force_delay_s;
  s.position_resolution_m = traits.position_resolution_m;
  s.device_damping_Ns_per_m = traits.damping_Ns_per_m;
  if (traits.largest_force_N > 0) s.largest_force_N = traits.largest_force_N;
  s.force_resolution_N = traits.force_resolution_N;
  return s;
}

}  // namespace phynness::devices
