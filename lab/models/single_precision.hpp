// Effect of single precision on the forces of family modal.
#pragma once

#include <phynness/formats/model.hpp>

namespace phynness::study {

struct SinglePrecision {
  /// |force in float - force in double| over the largest force, at random displacements within R.
  double force_mean = 0, force_max = 0;
  /// Work along closed quadrilaterals within R over the largest energy at a corner; the largest value.
  double loop_double = 0, loop_float = 0;
};
/// Means and largest over all nodes of the model.
SinglePrecision single_precision(const Model& model, std::uint64_t seed);

}  // namespace phynness::study
