// Bounds of errors, given along the directions of the training.
#include <cmath>

#include "core/bound.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Even and odd directions are compared independently, which a processor does at the same time.
std::int32_t nearest_direction(const phn_model& model, const double* d) {
  const double *e = model.directions, *end = e + 3 * static_cast<std::size_t>(model.n_directions), *even = e, *odd = e;
  double best_even = dot(d, e), best_odd = best_even;
  for (e += 3; e + 3 < end; e += 6) {
    const double a = dot(d, e), b = dot(d, e + 3);
    if (a > best_odd) {
      best_odd = a;
      odd = e;
    }
    if (b > best_even) {
      best_even = b;
      even = e + 3;
    }
  }
  if (e < end && dot(d, e) > best_odd) {
    best_odd = dot(d, e);
    odd = e;
  }
  return static_cast<std::int32_t>(((best_odd > best_even ? odd : even) - model.directions) / 3);
}

}  // namespace

double error_bound(const phn_model& model, const ActiveNode& node, const double* d) {
  const std::int32_t n_increments = model.n_displacements / model.n_directions;
  const std::int32_t first = nearest_direction(model, d) * n_increments;
  // Rows are in units of max_displacement in a family with modes, in m in the others.
  const double unit = schema::traits(model.kind).has_modes ? model.max_displacement_m : 1;
  return bound_along(model.displacements + 3 * static_cast<std::size_t>(first), n_increments, node.bound + first,
                     node.bound_scale, dot(d, d) / (unit * unit), [&] { return node.bound_at_rest; });
}

}  // namespace PHN_RUNTIME
