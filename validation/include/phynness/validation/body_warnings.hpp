// How often a reduced body warns.
#pragma once

#include <phynness/phynness.h>
#include <cstdint>
#include <phynness/formats/described.hpp>

namespace phynness {

struct BodyWarnings {
  std::int64_t unsettled = 0, outside = 0;  ///< answers with this warning of phn_body_press
  void take(int status) {
    unsettled += (status & PHN_WARNING_UNSETTLED) != 0;
    outside += (status & PHN_WARNING_OUTSIDE) != 0;
  }
  PHYNNESS_FIGURES(unsettled, outside)
};

}  // namespace phynness
