#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <phynness/validation/named_organ.hpp>
#include <set>

namespace phynness {
namespace {

/// The states of a ray are a cluster of the sample.
constexpr std::int64_t min_rays = 20;
/// The number of folds of the cross-validation that scores the predictions.
constexpr int n_folds = 10;
/// The largest number of tools of a state (CoupledRays).
constexpr std::int32_t max_tools = schema::n_coupled_kinds;
constexpr int n_coefficients = schema::n_coupled_terms;
/// Coefficients of the bounds of one tool, of two and of three.
using Rows = Eigen::Matrix<double, max_tools, n_coefficients>;

Rows unknown_bounds() {
  Rows rows = Rows::Zero();
  rows.col(0).setConstant(schema::no_coupled_bound);
  return rows;
}
/// Regularizes the logarithms of the terms [N] (formats/body.md, Bounds).
constexpr double least_term = 1e-12;
/// The index of the term that contains the spread of the nodes' forces, or the difference to the linear force.
constexpr int nonlinear_term = 2;

struct Sample {
  std::int32_t ray = 0, n_tools = 1;
  double depth_m = 0, error_N = 0;
  std::array<double, n_coefficients> terms{};  ///< 1, then logarithms

  double log_bound(const Eigen::Vector4d& c) const { return Eigen::Map<const Eigen::Vector4d>(terms.data()).dot(c); }
  double log_bound(const Rows& rows) const { return log_bound(Eigen::Vector4d(rows.row(n_tools - 1))); }
};
using Samples = std::vector<Sample>;

Sample sample_of(const CoupledState& state, const Vec3& predicted_N) {
  return {state.ray,
          state.n_tools,
          Eigen::Map<const Eigen::Vector3d>(state.tool.displacement).norm(),
          (to_eigen(predicted_N) - to_eigen(state.force_N)).norm(),
          {1}};
}

/// The runtime returns a multiple of a term as the bound if its coefficient is 1, and those of other terms are 0. The
/// multiple is so large that no bound of a node is larger.
Samples samples_between(const Model& model, const Mesh& mesh, const std::vector<CoupledState>& states) {
  constexpr double log_of_multiple = 60;
  Samples samples;
  for (int term = 1; term < n_coefficients; ++term) {
    Model with = model;
    with.bounds.at(0).between = log_of_multiple * Eigen::Vector4d::Unit(0) + Eigen::Vector4d::Unit(term);
    const NamedOrgan loaded(std::move(with), mesh, "model");
    std::size_t at = 0;
    for (const auto& state : states) {
      const auto response = loaded.hold({state.tool});
      if (response.bound_N.empty() || !response.bound_N[0]) continue;
      if (term == 1) samples.push_back(sample_of(state, *response.force_N[0]));
      samples.at(at++).terms[static_cast<std::size_t>(term)] = std::log(*response.bound_N[0]) - log_of_multiple;
    }
  }
  return samples;
}

Samples samples_of(const std::vector<CoupledState>& states, CoupledKind kind) {
  Samples samples;
  for (const auto& state : states) {
    if (state.kind != kind) continue;
    auto& sample = samples.emplace_back(sample_of(state, state.predicted_N));
    for (std::size_t i = 0; i < state.terms.size(); ++i) sample.terms[i + 1] = std::log(state.terms[i] + least_term);
  }
  return samples;
}

/// @param n_tools  number of tools of the counted rays; 0 counts all rays
std::int64_t rays_of(const Samples& samples, std::int32_t n_tools = 0) {
  std::set<std::int32_t> rays;
  for (const auto& sample : samples)
    if (n_tools == 0 || sample.n_tools == n_tools) rays.insert(sample.ray);
  return std::ssize(rays);
}

/// The shift of c_0 with which the bound covers the share `coverage` of the members (conformal prediction).
/// @param scores  for each sample, the logarithm of its error over the prediction
double conformal_shift(const Samples& samples, const std::vector<double>& scores, double coverage,
                       const auto& is_member) {
  std::vector<double> scores_of_members;
  std::set<std::int32_t> rays;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (is_member(samples[i])) {
      scores_of_members.push_back(scores[i]);
      rays.insert(samples[i].ray);
    }
  if (scores_of_members.empty()) return -std::numeric_limits<double>::infinity();
  std::sort(scores_of_members.begin(), scores_of_members.end());
  return quantile(scores_of_members, coverage * (1 + 1 / static_cast<double>(rays.size())));
}

/// The shift with which the bound of n tools, with whose number errors grow, covers the share `coverage` of their
/// samples, and nearly this share in each third of the depth; -infinity without samples.
double conformal_shift(const Samples& samples, const std::vector<double>& scores, double coverage, double range_m,
                       std::int32_t n) {
  double shift = conformal_shift(samples, scores, coverage, [&](const Sample& s) { return s.n_tools == n; });
  for (int third = 0; third < 3; ++third)
    shift = std::max(shift, conformal_shift(samples, scores, coverage - thirds_tolerance, [&](const Sample& s) {
                       return s.n_tools == n && std::min(2, static_cast<int>(3 * s.depth_m / range_m)) == third;
                     }));
  return shift;
}

/// Fits the coefficients of the logarithm of the error. @param held_out_fold  n_folds: no fold is held out
Eigen::Vector4d regression(const Samples& samples, int held_out_fold) {
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(std::ssize(samples), n_coefficients);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(std::ssize(samples));
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const auto& sample = samples[static_cast<std::size_t>(i)];
    if (sample.ray % n_folds == held_out_fold) continue;
    terms.row(i) = Eigen::Map<const Eigen::RowVector4d>(sample.terms.data());
    errors[i] = std::log(sample.error_N + smallest_error * std::exp(sample.terms[n_coefficients - 1]));
  }
  Eigen::Vector4d c = terms.completeOrthogonalDecomposition().solve(errors);
  if (c[nonlinear_term] >= 0) return c;
  // A negative exponent of this term, which vanishes near a node, would make the bound infinite there.
  terms.col(nonlinear_term).setZero();
  c = terms.completeOrthogonalDecomposition().solve(errors);
  c[nonlinear_term] = 0;
  return c;
}

/// Fits the coefficients of the logarithms of bounds that cover the share `coverage` of similar samples. Each sample is
/// scored by a prediction without its fold (Barber et al. 2021, doi 10.1214/20-AOS1965). The exponent of the predicted
/// error is the one with the narrowest bound in the mean; of several tools, whose errors extend over decades, the one
/// with the least product of mean and median.
Rows fit(const Samples& samples, double coverage, double range_m) {
  const Eigen::Vector4d all = regression(samples, n_folds);
  std::array<Eigen::Vector4d, n_folds> fold_regressions;
  for (int fold = 0; fold < n_folds; ++fold)
    fold_regressions[static_cast<std::size_t>(fold)] = regression(samples, fold);
  Rows best = unknown_bounds();
  double least = std::numeric_limits<double>::infinity();
  for (const double exponent : {0.4, 0.6, 0.8, 1.0}) {
    std::vector<double> scores;
    for (const auto& s : samples)
      scores.push_back(std::log(std::max(s.error_N, 1e-300)) -
                       exponent * s.log_bound(fold_regressions[static_cast<std::size_t>(s.ray % n_folds)]));
    Rows rows = unknown_bounds();
    for (std::int32_t n = 1; n <= max_tools; ++n) {
      const double shift = conformal_shift(samples, scores, coverage, range_m, n);
      if (std::isfinite(shift)) rows.row(n - 1) = (exponent * all + shift * Eigen::Vector4d::Unit(0)).transpose();
    }
    std::vector<double> bounds;
    for (const auto& sample : samples) bounds.push_back(std::exp(sample.log_bound(rows)));
    double width = std::accumulate(bounds.begin(), bounds.end(), 0.0);
    std::sort(bounds.begin(), bounds.end());
    if (samples[0].n_tools > 1) width *= quantile(bounds, 0.5);
    if (width >= least) continue;
    best = rows;
    least = width;
  }
  return best;
}

/// The coverage of each fold by bounds that are fitted on the other folds.
BoundCoverage cross_validated_coverage(const Samples& samples, double coverage, double range_m) {
  constexpr int n_coverage_folds = 5;
  std::vector<BoundedError> errors;
  for (int fold = 0; fold < n_coverage_folds; ++fold) {
    Samples training;
    std::ranges::copy_if(samples, std::back_inserter(training),
                         [&](const auto& s) { return s.ray % n_coverage_folds != fold; });
    if (training.empty()) continue;
    const Rows rows = fit(training, coverage, range_m);
    for (const auto& s : samples)
      if (s.ray % n_coverage_folds == fold) errors.push_back({s.depth_m, s.error_N, std::exp(s.log_bound(rows))});
  }
  return coverage_of(errors, range_m);
}

/// @return the coefficients; empty if the kind has too few rays
std::optional<Rows> fit_kind(const Samples& samples, double coverage, double range_m, CoupledCoverage& found) {
  found.rays = rays_of(samples);
  if (found.rays < min_rays) return std::nullopt;
  found.all = cross_validated_coverage(samples, coverage, range_m);
  found.promised = promised_coverage(found.rays, coverage);
  for (std::int32_t n = 1; n <= max_tools; ++n)
    if (const auto rays = rays_of(samples, n); rays > 0)
      found.promised = std::min(found.promised, promised_coverage(rays, coverage));
  return fit(samples, coverage, range_m);
}

}  // namespace

void add_bound_between(Model& model, const Mesh& mesh, const std::vector<CoupledState>& states,
                       CoupledCoverage& found) {
  auto& bound = model.bounds.at(0);
  const auto rows = fit_kind(samples_between(model, mesh, states), bound.coverage, model.max_displacement_m, found);
  if (rows) bound.between = rows->row(0);
}

void add_coupled_bounds(ReducedBody& body, double coverage, const std::vector<CoupledState>& states,
                        std::array<CoupledCoverage, 2>& found) {
  body.bounds.resize(0, n_coefficients);
  body.coverage = coverage;
  const auto one = fit_kind(samples_of(states, CoupledKind::one), coverage, body.depth_m, found[0]);
  const auto several = fit_kind(samples_of(states, CoupledKind::several), coverage, body.depth_m, found[1]);
  Rows rows = several ? *several : unknown_bounds();
  if (one) rows.row(0) = one->row(0);
  body.n_rays = static_cast<std::int32_t>(found[0].rays + found[1].rays);
  if ((rows.col(0).array() < schema::no_coupled_bound).any()) body.bounds = rows;
}

}  // namespace phynness
