#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/validation/tools.hpp>
#include <phynness/validation/validation.hpp>
#include <string_view>

namespace phynness {

const char* name(Predictor p) { return std::array{"model", "linear", "zero"}[static_cast<std::size_t>(p)]; }

double quantile(const std::vector<double>& ascending, double share) {
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(ascending.size())));
  return ascending[std::clamp<std::size_t>(rank, 1, ascending.size()) - 1];
}

ErrorStatistics ErrorStatistics::of(std::vector<double> samples) {
  ErrorStatistics s;
  s.n = static_cast<std::int64_t>(samples.size());
  if (samples.empty()) return s;
  std::sort(samples.begin(), samples.end());
  s.mean = std::accumulate(samples.begin(), samples.end(), 0.0) / static_cast<double>(samples.size());
  s.median = samples[(samples.size() - 1) / 2];
  s.p95 = quantile(samples, 0.95);
  s.max = samples.back();
  return s;
}

ByName<ErrorStatistics> GroupErrors::rows() const {
  auto rows = titled(*this);
  for (const auto& [name, errors] : fields) {
    rows.emplace_back(name + " (17)", errors.nodal);
    rows.emplace_back("  relative L2", errors.l2);
  }
  return rows;
}

std::string WorseThanLinear::sentence() const {
  const std::string_view of = range;
  const char* where = of == "inside"           ? "inside the trained range"
                      : of == "outside"        ? "beyond the trained range"
                      : of.ends_with("points") ? "for tools between nodes"
                      : of.ends_with("rim")    ? "at the rim of the probed part"
                                               : "for two tools";
  return fmt::format(
      "the {} is worse than the linear predictor {}: mean error of the {} {:.2f} %, of the linear predictor {:.2f} %",
      is_of_body() ? "reduced body" : "model", where, what, 100 * model, 100 * linear);
}

namespace {

/// Comparisons of the means of force and displacement in which the model is worse.
template <class Errors>
std::vector<WorseThanLinear> worse_in(const char* range, const Errors& model, const Errors& linear) {
  std::vector<WorseThanLinear> worse;
  const auto add = [&](const char* what, const ErrorStatistics& a, const ErrorStatistics& b) {
    constexpr double matters = 1e-3;
    if (a.n > 0 && b.n > 0 && a.mean > std::max(b.mean, matters)) worse.push_back({what, range, a.mean, b.mean});
  };
  add("force", model.force, linear.force);
  add("displacement", model.displacement, linear.displacement);
  return worse;
}

}  // namespace

std::vector<WorseThanLinear> worse_than_linear(const ValidationReport& report) {
  const auto &model = report.of(Predictor::model), &linear = report.of(Predictor::linear);
  auto worse = worse_in("inside", model.inside, linear.inside);
  std::ranges::copy(worse_in("outside", model.outside, linear.outside), std::back_inserter(worse));
  return worse;
}

std::vector<WorseThanLinear> worse_than_linear(const PointReport& report, SurfacePart part) {
  const bool is_rim = part == SurfacePart::rim;
  auto worse = worse_in(is_rim ? "rim" : "points", report.coupled, report.linear);
  if (report.body)
    std::ranges::copy(worse_in(is_rim ? "body_rim" : "body_points", *report.body, report.linear),
                      std::back_inserter(worse));
  return worse;
}

std::vector<WorseThanLinear> worse_than_linear(const PairReport& report) {
  return worse_in(report.by_body ? "body_pairs" : "pairs", report.unflagged.model, report.unflagged.linear);
}

}  // namespace phynness
