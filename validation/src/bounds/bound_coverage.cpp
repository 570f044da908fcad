#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/validation/bound_coverage.hpp>

namespace phynness {

BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m) {
  BoundCoverage out;
  out.states = std::ssize(errors);
  std::array<double, 3> covered_of{}, total_of{};  // weights in each third
  double covered = 0, total = 0, squares = 0;
  for (const auto& e : errors) {
    const auto third = std::min<std::size_t>(2, static_cast<std::size_t>(3 * e.depth_m / range_m));
    const bool holds = e.error_N <= e.bound_N;
    const double covered_weight = holds ? e.weight : 0;
    out.held += holds;
    total += e.weight;
    squares += e.weight * e.weight;
    covered += covered_weight;
    total_of[third] += e.weight;
    covered_of[third] += covered_weight;
  }
  for (std::size_t k = 0; k < 3; ++k)
    out.thirds[k] = total_of[k] > 0 ? covered_of[k] / total_of[k] : std::numeric_limits<double>::quiet_NaN();
  if (total > 0) out.all = covered / total, out.effective_states = total * total / squares;
  return out;
}

std::int64_t independent_errors(const Model& model, std::int64_t n_nodes, std::int64_t n_rays) {
  return static_cast<std::size_t>(n_nodes) < model.nodes.size() ? n_nodes : n_rays;
}

double promised_coverage(std::int64_t n, double coverage) {
  constexpr double risk = 0.05;
  const auto all = static_cast<double>(n), k = std::ceil(coverage * (all + 1));
  double low = 0, high = k > all ? 0 : 1;
  for (int halving = 0; halving < 40; ++halving) {
    const double x = (low + high) / 2;
    double cumulative = 0;  // the probability that at least k of n uniform numbers are below x
    for (double i = k; i <= all; ++i)
      cumulative += std::exp(std::lgamma(all + 1) - std::lgamma(i + 1) - std::lgamma(all - i + 1) + i * std::log(x) +
                             (all - i) * std::log1p(-x));
    (cumulative < risk ? low : high) = x;
  }
  return low;
}

double promised_coverage(const Model& model) {
  const auto& bound = model.bounds.at(0);
  return promised_coverage(independent_errors(model, bound.n_nodes, bound.n_rays), bound.coverage);
}

namespace {

constexpr std::int64_t few = 20;  // One error of more is at most the 5 % that a bound leaves.

}  // namespace

std::string held_of_errors(const BoundCoverage& measured) {
  return measured.states < few
             ? fmt::format("{} of {} error{}", measured.held, measured.states, measured.states == 1 ? "" : "s")
             : fmt::format("{:.0f} % of {} errors", 100 * measured.all, measured.states);
}

std::string held_in_words(const BoundCoverage& measured, double promised) {
  std::string text = "held for " + held_of_errors(measured);
  if (promised > 0) text += fmt::format(" (calibration promised {:.0f} %)", 100 * promised);
  if (const double deepest = measured.thirds.back(); measured.states >= few && !std::isnan(deepest))
    text += fmt::format(", for {:.0f} % of those in the deepest third", 100 * deepest);
  return text;
}

bool is_below_promise(const BoundCoverage& measured, double promised) {
  // Of the binomial distribution; a bound that just keeps its promise falls below in about one validation of 40.
  constexpr double standard_errors = 2;
  if (measured.states == 0) return false;
  return measured.all < promised - standard_errors * std::sqrt(promised * (1 - promised) / measured.effective_states);
}

}  // namespace phynness
