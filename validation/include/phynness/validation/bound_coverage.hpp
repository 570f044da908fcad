// The share of force errors at solved displacements that their bounds cover.
#pragma once

#include <array>
#include <cstdint>
#include <phynness/formats/described.hpp>
#include <phynness/formats/model.hpp>
#include <string>
#include <vector>

namespace phynness {

/// The share of covered errors in each third of the depth may be smaller than that of all errors by this.
inline constexpr double thirds_tolerance = 0.04;
/// The fit of the logarithms of errors replaces smaller errors by this part of the largest force.
inline constexpr double smallest_error = 1e-5;

/// A solved displacement inside the trained range.
struct BoundedError {
  double depth_m = 0, error_N = 0, bound_N = 0;
  double weight = 1;  ///< number of nodes that the sampled node represents
};

/// The weighted shares of displacements whose error is at most the bound.
struct BoundCoverage {
  std::int64_t states = 0, held = 0;  ///< number of errors, and of those at most their bound
  double all = 0;
  std::array<double, 3> thirds{};  ///< the shares in each third of the depth; nan without states
  double effective_states = 0;     ///< the effective sample size (sum of w)^2 / sum of w^2
  static void describe(const auto& c, auto&& see) {
    see("states", c.states);
    see("coverage", c.states > 0 ? c.all : undefined);
    see("thirds_of_depth", c.thirds);
  }
};

/// @param range_m  the depth that is divided into thirds
BoundCoverage coverage_of(const std::vector<BoundedError>& errors, double range_m);

/// The number of independent errors of a calibration: of its nodes, or of its rays if every node of the model has rays.
std::int64_t independent_errors(const Model& model, std::int64_t n_nodes, std::int64_t n_rays);

/// The share of new errors below a bound that 19 calibrations of 20 reach or exceed. The bound is the k-th smallest of
/// n independent ratios of error and prediction, k = ceil(coverage (n + 1)), and the share of new errors below it has
/// the distribution Beta(k, n + 1 - k) (Vovk 2012, arXiv:1209.2673). Errors at one place count once, because they are
/// correlated.
/// @param n  number of places, or of rays. @return 0 if n is too small for a bound
double promised_coverage(std::int64_t n, double coverage);
/// The same for the bound of a model at its nodes.
double promised_coverage(const Model& model);

/// "91 % of 100 errors"; of few, of which weights make a share that looks wrong, "4 of 5 errors"
std::string held_of_errors(const BoundCoverage& measured);
/// "held for 91 % of 100 errors, for 77 % of those in the deepest third; calibration promised 93 %"
/// @param measured  of at least one error. @param promised  0: nothing was
std::string held_in_words(const BoundCoverage& measured, double promised);
/// Whether the bound held less often than promised, by more than the sampling error of so many errors.
bool is_below_promise(const BoundCoverage& measured, double promised);

}  // namespace phynness
