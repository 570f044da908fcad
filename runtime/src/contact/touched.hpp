// What contact asks of the object that tools touch: a body, a model of a round tool, or a model of nodes.
#pragma once

#include <phynness/phynness_body.h>

#include "contact/touchable.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// Largest number of tools.
inline constexpr std::int32_t most_touching = PHN_MOST_COUPLED;

/// No function is pure, because the library links none for C++.
class Touched {
 public:
  bool has_energy = false;
  double max_displacement_m = 0;
  /// Newton's steps that are left for a phn_contact_step on a body, whose responses go on from the last one. -1: a
  /// model, whose responses depend on the tools alone.
  std::int32_t steps = -1;

  bool is_body() const { return steps >= 0; }
  /// Forces [N] that hold the tools, n x 3. @return a status of phynness.h
  virtual int hold(std::int32_t, const phn_tool*, double*, phn_coupled&) { return PHN_ERROR_UNDEFINED; }
  /// Of a tool of the last hold(), with the others held [N/m]: of a body at present, of a model at rest.
  virtual Matrix stiffness(std::int32_t) const { return {}; }
  /// Present mean displacement of a body under a tool [m]; zeros where that is not defined.
  virtual void displacement(const phn_tool&, double* mean) const { mean[0] = mean[1] = mean[2] = 0; }
};

}  // namespace PHN_RUNTIME
