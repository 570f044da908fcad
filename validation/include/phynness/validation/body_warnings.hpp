// How often a reduced body warns, and how its bounds hold.
#pragma once

#include <phynness/phynness.h>
#include <cstdint>
#include <phynness/formats/described.hpp>

namespace phynness {

struct BodyWarnings {
  std::int64_t unsettled = 0, outside = 0;  ///< answers with this warning of phn_body_press
  std::int64_t bounded = 0, covered = 0;    ///< forces with a bound; of these, with an error that is not above it
  void take(int status, std::int64_t with_bound, std::int64_t below) {
    bounded += with_bound;
    covered += below;
    unsettled += (status & PHN_WARNING_UNSETTLED) != 0;
    outside += (status & PHN_WARNING_OUTSIDE) != 0;
  }
  PHYNNESS_FIGURES(unsettled, outside, bounded, covered)
};

}  // namespace phynness
