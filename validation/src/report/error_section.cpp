// The errors of a report: tables, and errors beside their bounds.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <phynness/validation/report.hpp>

#include "blocks.hpp"

namespace phynness {

using namespace report;

namespace {

/// The smallest noticeable difference of a force is about 10 % (paper, section 5; Allin et al. 2002).
constexpr double noticeable = 0.10;

/// Probes whose force is off by more than a person may notice, which is a fraction of the present force (Weber's law).
std::string noticed(const Validated& in, bool outside) {
  const auto& all = in.report.records;
  const auto of = std::ranges::count(all, outside, &ProbeRecord::outside);
  const auto n =
      std::ranges::count_if(all, [&](const auto& r) { return r.outside == outside && r.force_error_own > noticeable; });
  return n == 0 ? "none is noticed" : fmt::format("{} of {} may be noticed", n, of);
}

/// How a row compares with the linear predictor and, for a force, with what a person may notice.
std::string verdict(const ErrorStatistics& model, const ErrorStatistics& linear, const std::string& of_force) {
  const std::string words = model.mean < linear.mean ? "better than linear" : "worse than linear";
  return of_force.empty() ? words : words + "; " + of_force;
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
                    verdict(m, l, i == 0 ? noticed(in, outside) : "")});
  }
}

void add_remarks(const ErrorsToRange& errors, std::vector<Json>& blocks) {
  for (const auto& remark : remarks(errors)) blocks.push_back(text(remark + "."));
}

void add_warnings(const std::optional<BodyWarnings>& of_body, std::vector<Json>& blocks) {
  if (of_body)
    blocks.push_back(text(fmt::format("the reduced body: {} unsettled, {} outside of its trained range",
                                      of_body->unsettled, of_body->outside)));
  if (of_body && of_body->bounded > 0)
    blocks.push_back(
        text(fmt::format("{} of {} errors of its forces are below their bound", of_body->covered, of_body->bounded)));
}

Json time_and_residual(const auto& report) {
  return text(fmt::format("largest distance of a tool from its point in the field: {:.1e} m; {:.1f} s",
                          report.largest_residual_m, report.seconds));
}

}  // namespace

Json points_section(const PointReport& report) {
  std::vector<Json> blocks{
      text(fmt::format("{} points of the surface, {} displacements each; {} not solved, {} unsettled in the model",
                       report.finished, report.displacements, report.failed, report.unsettled))};
  if (report.refused > 0)
    blocks.push_back(
        text(fmt::format("{} of those not solved are refused, such as: {}", report.refused, report.first_refusal)));
  if (report.failed > report.refused)
    blocks.push_back(
        text(fmt::format("{} of those not solved did not converge; --increments of phynness solve helps to see why",
                         report.failed - report.refused)));
  std::vector<std::pair<const char*, const PointErrors*>> predictors{{"coupled model", &report.coupled},
                                                                     {"linear predictor", &report.linear},
                                                                     {"model at the nearest nodes", &report.at_nodes}};
  if (report.body) predictors.emplace_back("reduced body", &*report.body);
  TableCells rows{{"error in %", "mean", "median", "p95", "max"}};
  for (std::size_t i = 0; i < titled(PointErrors{}).size(); ++i)
    for (const auto& [who, errors] : predictors) {
      const auto [what, s] = titled(*errors)[i];
      rows.push_back({fmt::format("{}, {}", what, who), in_percent(s.mean), in_percent(s.median), in_percent(s.p95),
                      in_percent(s.max)});
    }
  blocks.push_back(table(rows));
  add_warnings(report.body_warnings, blocks);
  add_remarks(report.to_range, blocks);
  blocks.push_back(time_and_residual(report));
  return section("Tools between nodes", blocks);
}

Json pairs_section(const PairReport& report) {
  std::vector<Json> blocks{
      text(fmt::format("{} pairs of nodes, both tools {:.4g} mm deep; {} not solved, {} unsettled, {} outside of "
                       "the trained range; {} are at most {:.0f} mm apart, and {} have no warning",
                       report.finished, 1e3 * report.depth_m, report.failed, report.unsettled, report.outside,
                       report.near.pairs, 1e3 * report.far_m, report.unflagged.pairs))};
  TableCells rows{{"error in %", "all: mean", "median", "p95", "max", "unflagged: mean", "p95", "near: mean", "median",
                   "far: mean", "median"}};
  const auto shown = [](const ErrorStatistics& s, double value) { return s.n > 0 ? in_percent(value) : "-"; };
  for (std::size_t i = 0; i < titled(PairStatistics{}).size(); ++i) {
    rows.push_back({titled(PairStatistics{})[i].first});
    for (const auto p : pair_predictors) {
      const auto of = [&](const PairGroup& group) { return titled(group.of(p))[i].second; };
      const auto all = of(report.all), quiet = of(report.unflagged), near = of(report.near), far = of(report.far);
      if (all.n == 0) continue;
      constexpr std::array who{"coupled model", "each tool alone", "weights (15)-(16)", "linear predictor",
                               "reduced body"};
      rows.push_back({fmt::format("  {}", who[static_cast<std::size_t>(p)]), in_percent(all.mean),
                      in_percent(all.median), in_percent(all.p95), in_percent(all.max), shown(quiet, quiet.mean),
                      shown(quiet, quiet.p95), shown(near, near.mean), shown(near, near.median), shown(far, far.mean),
                      shown(far, far.median)});
    }
  }
  blocks.push_back(table(rows));
  add_warnings(report.body_warnings, blocks);
  if (report.by_warning) blocks.push_back(table(table_cells("two tools, in %", *report.by_warning)));
  if (report.body_by_warning) blocks.push_back(table(table_cells("reduced body, in %", *report.body_by_warning)));
  const auto& judged = report.by_warning ? report.by_warning : report.body_by_warning;
  if (const auto why = judged ? reasons(judged->unreached) : std::string(); !why.empty())
    blocks.push_back(text("not reached by the finite elements: " + why));
  if (const auto& alone = report.single_force; alone.n > 0)
    blocks.push_back(text(fmt::format("larger force error of the two tools alone: mean {}, median {}, max {} %",
                                      in_percent(alone.mean), in_percent(alone.median), in_percent(alone.max))));
  blocks.push_back(time_and_residual(report));
  return section("Two tools", blocks);
}

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
      text(sentence(trained_share(model), model) + ".")};
  add_remarks(in.report.to_range, blocks);
  if (in.report.to_range.bounds)
    for (auto& plots : bound_plots(in)) blocks.push_back(std::move(plots));
  return section("Errors", blocks);
}

}  // namespace phynness
