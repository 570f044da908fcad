#include <algorithm>
#include <limits>
#include <phynness/validation/bound_coverage.hpp>

namespace phynness {

BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m) {
  BoundCoverage out;
  out.states = std::ssize(errors);
  std::array<double, 3> held_of{}, drawn_of{};  // thirds
  double held = 0, drawn = 0;
  for (const auto& e : errors) {
    const auto third = std::min<std::size_t>(2, static_cast<std::size_t>(3 * e.depth_m / range_m));
    const double below = e.error_N <= e.bound_N ? e.weight : 0;
    drawn += e.weight;
    held += below;
    drawn_of[third] += e.weight;
    held_of[third] += below;
  }
  for (std::size_t k = 0; k < 3; ++k)
    out.thirds[k] = drawn_of[k] > 0 ? held_of[k] / drawn_of[k] : std::numeric_limits<double>::quiet_NaN();
  if (drawn > 0) out.all = held / drawn;
  return out;
}

}  // namespace phynness
