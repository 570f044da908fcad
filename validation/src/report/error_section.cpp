// The errors of a report: tables, histograms, and errors beside their bounds.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <phynness/validation/trained_share.hpp>

#include "blocks.hpp"

namespace phynness {

using namespace report;

namespace {

/// The smallest noticeable difference of a force is about 10 % (paper, section 5; Allin et al. 2002).
constexpr double noticeable = 0.10;

struct Noticed {
  std::size_t n = 0, of = 0;
  std::string share() const { return fmt::format("{} of {}", n, of); }
};
/// Probes whose force is off by more than a person may notice, which is a fraction of the present force (Weber's law).
/// Forces below 1 % of the node's largest count as that: they are hardly felt.
Noticed noticed(const Validated& in, bool outside) {
  std::map<std::int32_t, double> largest;
  for (const auto& r : in.report.records)
    if (r.outside == outside) largest[r.node] = std::max(largest[r.node], to_eigen(r.finite_elements_N).norm());
  Noticed found;
  for (const auto& r : in.report.records) {
    if (r.outside != outside) continue;
    const double size = std::max(to_eigen(r.finite_elements_N).norm(), 0.01 * largest[r.node]);
    ++found.of;
    found.n += (to_eigen(r.model_N) - to_eigen(r.finite_elements_N)).norm() > noticeable * size;
  }
  return found;
}

/// How a row compares with the linear predictor and, for a force, with what a person may notice.
std::string verdict(const ErrorStatistics& model, const ErrorStatistics& linear, const std::optional<Noticed>& force) {
  const std::string words = model.mean < linear.mean ? "better than linear" : "worse than linear";
  if (!force) return words;
  return words + (force->n == 0 ? "; none is noticed" : fmt::format("; {} may be noticed", force->share()));
}

/// Errors beside their bounds, and the share of errors below their bound by tenths of the depth.
std::vector<Json> bound_plots(const Validated& in) {
  const auto& errors = in.report.to_range;
  const auto& samples = errors.bounds->samples;
  const double coverage = 100 * in.model.model().bounds.at(0).coverage;
  constexpr std::size_t n_parts = 10;
  constexpr double least = 1e-3;  // %; smaller values are shown as this
  std::vector<std::pair<double, double>> points, share;
  std::array<double, n_parts> held{}, drawn{};
  double largest = least;
  for (const auto& s : samples) {
    if (s.largest_N <= 0) continue;
    const double bound = std::max(least, 100 * s.bound_N / s.largest_N);
    points.emplace_back(bound, std::max(least, 100 * s.error_N / s.largest_N));
    largest = std::max(largest, bound);
    const double part = std::floor(static_cast<double>(n_parts) * s.depth_m / errors.range_m);
    const auto at = std::min(n_parts - 1, static_cast<std::size_t>(part));
    drawn[at] += 1;
    held[at] += s.error_N <= s.bound_N ? 1 : 0;
  }
  if (points.empty()) return {};
  for (std::size_t i = 0; i < n_parts; ++i)
    if (drawn[i] > 0)
      share.emplace_back(1e3 * errors.range_m * (static_cast<double>(i) + 0.5) / n_parts, 100 * held[i] / drawn[i]);
  const std::vector<std::pair<double, double>> wanted{{0, coverage}, {1e3 * errors.range_m, coverage}};
  return {charts(
      {chart("Errors below the line are below their bound", "bound, % of the node's largest force", "error, %",
             {{"probes to R", "points", 0, points}, {"error = bound", "line", 2, {{least, least}, {largest, largest}}}},
             {{"log_x", true}, {"log_y", true}}),
       chart("Share of errors below their bound", "depth, mm", "probes, %",
             {{"calibrated for", "dashes", 2, wanted}, {"probes to R", "joined", 0, share}}, {{"range", {50, 100}}})})};
}

/// Percentages of samples in each third of a decade, from the smallest to the largest sample. Samples below `least`
/// count as `least`.
std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least) {
  std::map<int, int> bins;
  for (const double sample : samples) ++bins[static_cast<int>(std::floor(3 * std::log10(std::max(sample, least))))];
  std::vector<std::pair<double, double>> steps;
  if (bins.empty()) return steps;
  steps.emplace_back(std::pow(10, bins.begin()->first / 3.0), 0);
  for (int bin = bins.begin()->first; bin <= bins.rbegin()->first; ++bin) {
    const auto found = bins.find(bin);
    const double share = found == bins.end() ? 0 : 100.0 * found->second / static_cast<double>(samples.size());
    steps.emplace_back(std::pow(10, bin / 3.0), share);
    steps.emplace_back(std::pow(10, (bin + 1) / 3.0), share);
  }
  steps.emplace_back(steps.back().first, 0);
  return steps;
}

/// Errors of the predictors, in a group of probes.
void add_rows(const Validated& in, bool outside, Rows& rows) {
  const auto of = [&](Predictor p) {
    const auto& errors = in.report.of(p);
    return (outside ? errors.outside : errors.inside).rows();
  };
  const auto model = of(Predictor::model), linear = of(Predictor::linear), zero = of(Predictor::zero);
  for (std::size_t i = 0; i < model.size(); ++i) {
    const auto& [title, m] = model[i];
    const auto &l = linear[i].second, &z = zero[i].second;
    if (m.n == 0) continue;
    rows.push_back({title + (outside ? ", outside" : ", inside"), percent(m.mean), percent(m.median), percent(m.p95),
                    percent(m.max), percent(l.mean), percent(l.p95), percent(l.max), percent(z.mean),
                    verdict(m, l, i == 0 ? std::optional(noticed(in, outside)) : std::nullopt)});
  }
}

/// Histograms of the errors of a group of probes; nothing if it has none.
std::vector<Json> histograms(const Validated& in, bool outside) {
  std::vector<double> force, force_linear, u, u_linear;
  for (const auto& r : in.report.records) {
    if (r.outside != outside) continue;
    force.push_back(100 * r.force_error);
    force_linear.push_back(100 * r.force_error_linear);
    u.push_back(100 * r.displacement_error);
    u_linear.push_back(100 * r.displacement_error_linear);
  }
  if (force.empty()) return {};
  const auto both = [&](const char* what, const std::vector<double>& model, const std::vector<double>& linear) {
    constexpr double least = 1e-3;
    return chart(
        fmt::format("{}, {} the trained range", what, outside ? "outside" : "inside"), "error (17) of a probe, %",
        "probes, %",
        {{"linear predictor", "dashes", 1, histogram(linear, least)}, {"model", "line", 0, histogram(model, least)}},
        {{"log_x", true}});
  };
  std::vector<Json> all{both("Force", force, force_linear)};
  if (in.report.of(Predictor::model).inside.displacement.n > 0) all.push_back(both("Displacement", u, u_linear));
  return {charts(all)};
}

}  // namespace

Json error_section(const Validated& in) {
  Rows rows{
      {"error in %", "model: mean", "median", "p95", "max", "linear: mean", "p95", "max", "zero: mean", "verdict"}};
  for (const bool outside : {false, true}) add_rows(in, outside, rows);
  const Model& model = in.model.model();
  std::vector<Json> blocks{
      folded("Errors inside and outside the trained range", rows),
      text(fmt::format(
          "A person may notice a force that is off by more than {:.0f} % of its own size (Allin et al. 2002).",
          100 * noticeable)),
      folded("Errors to R by warnings, depth and bounds", table_cells(in.report.to_range)),
      text(sentence(trained_share(model), model) + ".")};
  for (const auto& remark : remarks(in.report.to_range)) blocks.push_back(text(remark + "."));
  for (const auto& plots :
       {histograms(in, false), histograms(in, true), in.report.to_range.bounds ? bound_plots(in) : std::vector<Json>{}})
    blocks.insert(blocks.end(), plots.begin(), plots.end());
  return section("Errors", blocks);
}

}  // namespace phynness
