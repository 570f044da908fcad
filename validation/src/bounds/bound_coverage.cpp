#include <algorithm>
#include <cmath>
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

double promised_coverage(std::int64_t n, double coverage) {
  constexpr double risk = 0.05;
  const auto all = static_cast<double>(n), k = std::ceil(coverage * (all + 1));
  double low = 0, high = k > all ? 0 : 1;
  for (int halving = 0; halving < 40; ++halving) {
    const double x = (low + high) / 2;
    double below = 0;  // the distribution function at x: of n uniform numbers at least k are below x
    for (double i = k; i <= all; ++i)
      below += std::exp(std::lgamma(all + 1) - std::lgamma(i + 1) - std::lgamma(all - i + 1) + i * std::log(x) +
                        (all - i) * std::log1p(-x));
    (below < risk ? low : high) = x;
  }
  return low;
}

}  // namespace phynness
