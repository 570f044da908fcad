#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/validation/coupled_bounds.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <phynness/validation/named_organ.hpp>
#include <set>

namespace phynness {
namespace {

/// A third of the depth may be covered by this less than all.
constexpr double holds_nearly = 0.04;
/// Errors below this part of the feature of force count as this in the fit of their logarithms.
constexpr double least_error = 1e-5;
/// The rays are a sample of clusters.
constexpr std::int64_t fewest_of_kind = 20;
/// A prediction is made without each of these parts of the rays.
constexpr int n_parts = 10;
/// Tools of a state, at most (CoupledRays).
constexpr std::int32_t most_tools = 3;
constexpr int n_coefficients = schema::n_coupled_terms;
/// Added to what bounds are computed from [N] (formats/body.md, Bounds).
constexpr double least_term = 1e-12;
/// The term of the spread of the nodes' forces, or of the difference to the linear force.
constexpr int bending = 2;

struct Sample {
  std::int32_t ray = 0, n_tools = 1;
  double depth_m = 0, error_N = 0;
  std::array<double, n_coefficients> terms{};  ///< 1 and logarithms

  double times(const Eigen::Vector4d& c) const { return Eigen::Map<const Eigen::Vector4d>(terms.data()).dot(c); }
};
using Samples = std::vector<Sample>;

Sample sample_of(const CoupledState& state, const Vec3& said_N) {
  return {state.ray,
          state.n_tools,
          Eigen::Map<const Eigen::Vector3d>(state.tool.displacement).norm(),
          (to_eigen(said_N) - to_eigen(state.force_N)).norm(),
          {1}};
}

/// What bounds are computed from are bounds of which one coefficient is 1 and the others are 0.
Samples samples_between(const Model& model, const Mesh& mesh, const std::vector<CoupledState>& states) {
  Samples samples;
  for (int term = 1; term < n_coefficients; ++term) {
    Model with = model;
    with.bounds.at(0).between = Eigen::Vector4d::Unit(term);
    const NamedOrgan loaded(std::move(with), mesh, "model");
    std::size_t at = 0;
    for (const auto& state : states) {
      const auto said = loaded.hold({state.tool});
      if (said.bound_N.empty() || !said.bound_N[0]) continue;
      if (term == 1) samples.push_back(sample_of(state, *said.force_N[0]));
      samples.at(at++).terms[static_cast<std::size_t>(term)] = std::log(*said.bound_N[0]);
    }
  }
  return samples;
}

Samples samples_of(const std::vector<CoupledState>& states, CoupledKind kind) {
  Samples samples;
  for (const auto& state : states) {
    if (state.kind != kind) continue;
    auto& sample = samples.emplace_back(sample_of(state, state.said_N));
    for (std::size_t i = 0; i < state.terms.size(); ++i) sample.terms[i + 1] = std::log(state.terms[i] + least_term);
  }
  return samples;
}

/// @param n_tools  of those that count; 0: all count
std::int64_t rays_of(const Samples& samples, std::int32_t n_tools = 0) {
  std::set<std::int32_t> rays;
  for (const auto& sample : samples)
    if (n_tools == 0 || sample.n_tools == n_tools) rays.insert(sample.ray);
  return std::ssize(rays);
}

/// What must be added to c_0 for the bound to hold for the share `coverage` of those that belong.
/// @param scores  of each sample, the logarithm of its error over the prediction
double missing(const Samples& samples, const std::vector<double>& scores, double coverage, const auto& belongs) {
  std::vector<double> those;
  std::set<std::int32_t> rays;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (belongs(samples[i])) {
      those.push_back(scores[i]);
      rays.insert(samples[i].ray);
    }
  if (those.empty()) return -std::numeric_limits<double>::infinity();
  std::sort(those.begin(), those.end());
  return quantile(those, coverage * (1 + 1 / static_cast<double>(rays.size())));
}

/// The same for the share `coverage` of all and of those of each number of tools, whose errors grow with it, and nearly
/// so in each third of the depth.
double missing(const Samples& samples, const std::vector<double>& scores, double coverage, double range_m) {
  double more = missing(samples, scores, coverage, [](const Sample&) { return true; });
  for (std::int32_t n = 1; n <= most_tools; ++n)
    more = std::max(more, missing(samples, scores, coverage, [&](const Sample& s) { return s.n_tools == n; }));
  for (int third = 0; third < 3; ++third)
    more = std::max(more, missing(samples, scores, coverage - holds_nearly, [&](const Sample& s) {
                      return std::min(2, static_cast<int>(3 * s.depth_m / range_m)) == third;
                    }));
  return more;
}

/// Coefficients of the logarithm of the error. @param left_out  part of the rays that does not count; n_parts: all
/// count
Eigen::Vector4d predicted(const Samples& samples, int left_out) {
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(std::ssize(samples), n_coefficients);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(std::ssize(samples));
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const auto& sample = samples[static_cast<std::size_t>(i)];
    if (sample.ray % n_parts == left_out) continue;
    terms.row(i) = Eigen::Map<const Eigen::RowVector4d>(sample.terms.data());
    errors[i] = std::log(sample.error_N + least_error * std::exp(sample.terms[n_coefficients - 1]));
  }
  Eigen::Vector4d c = terms.completeOrthogonalDecomposition().solve(errors);
  if (c[bending] >= 0) return c;
  // What vanishes beside a node would make the bound infinite there.
  terms.col(bending).setZero();
  c = terms.completeOrthogonalDecomposition().solve(errors);
  c[bending] = 0;
  return c;
}

/// Coefficients of the logarithm of a bound that holds for the share `coverage` of samples like these: each is scored
/// by a prediction without its part of the rays (Barber et al. 2021, doi 10.1214/20-AOS1965). Of the exponents of the
/// predicted error the narrowest bound is taken that holds at every third of the depth.
Eigen::Vector4d fit(const Samples& samples, double coverage, double range_m) {
  const Eigen::Vector4d all = predicted(samples, n_parts);
  std::array<Eigen::Vector4d, n_parts> without;
  for (int part = 0; part < n_parts; ++part) without[static_cast<std::size_t>(part)] = predicted(samples, part);
  Eigen::Vector4d best = all;
  double least = std::numeric_limits<double>::infinity();
  for (const double exponent : {0.4, 0.6, 0.8, 1.0}) {
    std::vector<double> scores;
    for (const auto& s : samples)
      scores.push_back(std::log(std::max(s.error_N, 1e-300)) -
                       exponent * s.times(without[static_cast<std::size_t>(s.ray % n_parts)]));
    Eigen::Vector4d c = exponent * all;
    c[0] += missing(samples, scores, coverage, range_m);
    double sum = 0;
    for (const auto& sample : samples) sum += std::exp(sample.times(c));
    if (sum >= least) continue;
    best = c;
    least = sum;
  }
  return best;
}

/// How bounds hold for a fifth of the rays at a time that the others give.
BoundCoverage left_out(const Samples& samples, double coverage, double range_m) {
  constexpr int n_fifths = 5;
  std::vector<BoundedError> errors;
  for (int part = 0; part < n_fifths; ++part) {
    Samples kept;
    std::ranges::copy_if(samples, std::back_inserter(kept), [&](const auto& s) { return s.ray % n_fifths != part; });
    if (kept.empty()) continue;
    const Eigen::Vector4d c = fit(kept, coverage, range_m);
    for (const auto& s : samples)
      if (s.ray % n_fifths == part) errors.push_back({s.depth_m, s.error_N, std::exp(s.times(c))});
  }
  return coverage_of(errors, range_m);
}

/// @return the coefficients, if there are enough rays of the kind
std::optional<Eigen::Vector4d> fit_kind(const Samples& samples, double coverage, double range_m,
                                        CoupledCoverage& found) {
  found.rays = rays_of(samples);
  if (found.rays < fewest_of_kind) return std::nullopt;
  found.all = left_out(samples, coverage, range_m);
  found.promised = promised_coverage(found.rays, coverage);
  for (std::int32_t n = 1; n <= most_tools; ++n)
    if (const auto rays = rays_of(samples, n); rays > 0)
      found.promised = std::min(found.promised, promised_coverage(rays, coverage));
  return fit(samples, coverage, range_m);
}

}  // namespace

void add_bound_between(Model& model, const Mesh& mesh, const std::vector<CoupledState>& states,
                       CoupledCoverage& found) {
  auto& bound = model.bounds.at(0);
  const auto c = fit_kind(samples_between(model, mesh, states), bound.coverage, model.max_displacement_m, found);
  if (c) bound.between = *c;
}

void add_coupled_bounds(ReducedBody& body, double coverage, const std::vector<CoupledState>& states,
                        std::array<CoupledCoverage, 2>& found) {
  body.bounds.resize(0, n_coefficients);
  body.coverage = coverage;
  Eigen::Matrix<double, schema::n_coupled_kinds, n_coefficients> rows;
  rows.setZero();
  rows.col(0).setConstant(schema::no_coupled_bound);
  for (const auto kind : {CoupledKind::one, CoupledKind::several}) {
    const auto at = static_cast<std::size_t>(kind);
    const auto c = fit_kind(samples_of(states, kind), coverage, body.depth_m, found[at]);
    if (c) rows.row(static_cast<Eigen::Index>(at)) = c->transpose();
  }
  body.n_rays = static_cast<std::int32_t>(found[0].rays + found[1].rays);
  if ((rows.col(0).array() < schema::no_coupled_bound).any()) body.bounds = rows;
}

}  // namespace phynness
