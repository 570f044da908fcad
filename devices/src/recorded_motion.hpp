// Positions of a motion file of phynness (formats/motion.md), for RecordedDevice.
#pragma once

#include <phynness/phynness_loop.h>

#include <string>
#include <vector>

namespace phynness::devices {

/// Displacements [m] of the only tool, every `period_s` seconds from the first time to the last, linear between the
/// steps of the file.
/// @throws std::runtime_error  with the file and what is wrong
std::vector<phn_loop_sample> samples_of_motion(const std::string& text, const std::string& file, double period_s);

}  // namespace phynness::devices
