// Text output of `phynness validate`.
#include <algorithm>
#include <cmath>
#include <phynness/formats/locking.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/trained_share.hpp>
#include <phynness/validation/verdict.hpp>

#include "commands.hpp"

namespace phynness::cli {
namespace {

std::string percent(double fraction) { return fmt::format("{:>5}", in_percent(fraction)); }

/// A rank correlation, or the reason why it is missing.
std::string told(const std::optional<double>& correlation) {
  return correlation ? fmt::format("{:.2f}", *correlation) : "too few probes";
}

/// The first column to the left, the others to the right.
void print_cells(const TableCells& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  const auto& headings = rows.front();
  for (std::size_t first = 1, end = 1; first < headings.size(); first = end) {
    for (std::size_t i = first, width = widths[0]; i <= headings.size(); ++i) {
      const bool group_ends = i == headings.size() || (i > first && headings[i].find(": ") != std::string::npos);
      if (group_ends && end > first && width > 100) break;
      if (group_ends) end = i;
      if (i < headings.size()) width += 2 + widths[i];
    }
    for (const auto& row : rows) {
      std::string line = fmt::format("{:<{}}", row[0], widths[0]);
      for (std::size_t i = first; i < end; ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
      line.erase(line.find_last_not_of(' ') + 1);
      print_result("{}\n", line);
    }
  }
}

void print_to_range(const ErrorsToRange& errors) {
  if (errors.all.overall.probes == 0) return;
  print_cells(table_cells(errors));
  for (const auto& remark : remarks(errors)) print_result("{}\n", remark);
}

void print_table(const ValidationReport& report) {
  const auto row = [&](std::size_t i, GroupErrors PredictorErrors::*group) {
    print_result("  {:<22}", (report.of(Predictor::model).*group).rows()[i].first);
    for (const auto p : predictors) {
      const auto s = (report.of(p).*group).rows()[i].second;
      if (s.n == 0)
        print_result(" | {:>5} {:>5} {:>5}", "-", "-", "-");
      else
        print_result(" | {} {} {}", percent(s.mean), percent(s.p95), percent(s.max));
    }
    print_result("\n");
  };
  for (const auto& [title, group] : {std::pair{"inside the trained range", &PredictorErrors::inside},
                                     std::pair{"outside, to 1.43 times", &PredictorErrors::outside}}) {
    print_result("{:<24} | {:^17} | {:^17} | {:^17}\n", title, "model", "linear predictor", "zero predictor");
    print_result("{:<24}", "  error in %");
    for (std::size_t i = 0; i < predictors.size(); ++i) print_result(" | {:>5} {:>5} {:>5}", "mean", "p95", "max");
    print_result("\n");
    for (std::size_t i = 0; i < (report.of(Predictor::model).*group).rows().size(); ++i) row(i, group);
  }
}

void print_summary(const ValidationReport& report) {
  const auto& inside = report.of(Predictor::model).inside;
  if (inside.force.n > 0) print_result("median inside: force {} %", in_percent(inside.force.median));
  if (inside.displacement.n > 0) print_result(", displacement {} %", in_percent(inside.displacement.median));
  if (inside.force.n > 0) print_result("\n");
  print_result("rank correlation of the force error with the distance from the training data: {} inside, {} outside\n",
               told(report.distance_correlation_inside), told(report.distance_correlation_outside));
}

void print_examples(const ValidationReport& report) {
  double largest = 0;
  for (const auto& e : report.examples)
    for (const double x : e.finite_elements_N) largest = std::max(largest, std::abs(x));
  const ForceUnit unit = force_unit(largest);
  print_result("{:<8} {:>24} | {:>27} | {:>27}\n", "node", "displacement, mm",
               fmt::format("force by finite elements, {}", unit.name),
               fmt::format("force by the model, {}", unit.name));
  for (const auto& e : report.examples) {
    print_result("{:<8}", e.node);
    for (const double x : e.displacement_m) print_result(" {:8.2f}", 1e3 * x);
    print_result(" |");
    for (const double x : e.finite_elements_N) print_result(" {:8.2f}", unit.per_N * x);
    print_result("  |");
    for (const double x : e.model_N) print_result(" {:8.2f}", unit.per_N * x);
    print_result("\n");
  }
}

void print_warnings(const std::optional<BodyWarnings>& of_body) {
  if (of_body)
    print_result("the reduced body: {} unsettled, {} outside of its trained range\n", of_body->unsettled,
                 of_body->outside);
  if (of_body && of_body->bounded > 0)
    print_result("{} of {} errors of its forces are below their bound\n", of_body->covered, of_body->bounded);
}

void print_points(const PointReport& report) {
  print_result("{} points of the surface, {} displacements each; {} not solved, {} unsettled in the model\n",
               report.finished, report.displacements, report.failed, report.unsettled);
  if (report.refused > 0)
    print_result("  {} of those not solved are refused, such as: {}\n", report.refused, report.first_refusal);
  if (report.failed > report.refused)
    print_result("  {} of those not solved did not converge; --increments of phynness solve helps to see why\n",
                 report.failed - report.refused);
  TableCells rows{{"tools between nodes, error in %", "mean", "median", "p95", "max"}};
  std::vector<std::pair<const char*, decltype(titled(report.coupled))>> predictors{
      {"coupled model", titled(report.coupled)},
      {"linear predictor", titled(report.linear)},
      {"model at the nearest nodes", titled(report.at_nodes)}};
  if (report.body) predictors.emplace_back("reduced body", titled(*report.body));
  for (std::size_t i = 0; i < predictors.front().second.size(); ++i)
    for (const auto& [who, errors] : predictors) {
      const auto& [what, s] = errors[i];
      rows.push_back({fmt::format("  {}, {}", what, who), in_percent(s.mean), in_percent(s.median), in_percent(s.p95),
                      in_percent(s.max)});
    }
  print_cells(rows);
  print_warnings(report.body_warnings);
  print_to_range(report.to_range);
  print_result("largest distance of a tool from its point in the field: {:.1e} m; {}\n", report.largest_residual_m,
               duration(report.seconds));
}

void print_pairs(const PairReport& report) {
  print_result(
      "{} pairs of nodes, both tools {:.4g} mm deep; {} not solved, {} unsettled in the model, {} outside of its "
      "trained range\n",
      report.finished, 1e3 * report.depth_m, report.failed, report.unsettled, report.outside);
  const double far_mm = 1e3 * report.far_m;
  print_result("{:<24} | {:^24} | {:^13} | {:^12} | {:^12}\n", "two tools, error in %",
               fmt::format("all, {}", report.all.pairs), fmt::format("unflagged, {}", report.unflagged.pairs),
               fmt::format("to {:.0f} mm, {}", far_mm, report.near.pairs), fmt::format("beyond, {}", report.far.pairs));
  print_result("{:<24} | {:>5} {:>6} {:>5} {:>5} | {:>6} {:>6}", "", "mean", "median", "p95", "max", "mean", "p95");
  for (int i = 0; i < 2; ++i) print_result(" | {:>5} {:>6}", "mean", "median");
  print_result("\n");
  for (std::size_t i = 0; i < titled(PairStatistics{}).size(); ++i) {
    const auto measure = [i](const PairGroup& group, PairPredictor p) { return titled(group.of(p))[i].second; };
    print_result("  {}\n", titled(PairStatistics{})[i].first);
    for (const auto p : pair_predictors) {
      const auto all = measure(report.all, p);
      if (all.n == 0) continue;
      const char* who = p == PairPredictor::coupled ? "coupled model"
                        : p == PairPredictor::alone ? "each tool alone"
                        : p == PairPredictor::paper ? "weights (15)-(16)"
                        : p == PairPredictor::body  ? "reduced body"
                                                    : "linear predictor";
      print_result("    {:<20} | {}  {} {} {}", who, percent(all.mean), percent(all.median), percent(all.p95),
                   percent(all.max));
      const auto quiet = measure(report.unflagged, p);
      print_result(" | {:>6} {:>6}", quiet.n > 0 ? in_percent(quiet.mean) : "-",
                   quiet.n > 0 ? in_percent(quiet.p95) : "-");
      for (const auto* group : {&report.near, &report.far}) {
        const auto s = measure(*group, p);
        if (s.n == 0)
          print_result(" | {:>5} {:>6}", "-", "-");
        else
          print_result(" | {}  {}", percent(s.mean), percent(s.median));
      }
      print_result("\n");
    }
  }
  print_warnings(report.body_warnings);
  print_cells(table_cells("two tools, in %", report.by_warning));
  if (report.body_by_warning) print_cells(table_cells("reduced body, in %", *report.body_by_warning));
  if (const auto why = reasons(report.by_warning.unreached); !why.empty())
    print_result("not reached by the finite elements: {}\n", why);
  const auto& alone = report.single_force;
  if (alone.n > 0)
    print_result("larger force error of the two tools alone: mean {}, median {}, max {} %\n", in_percent(alone.mean),
                 in_percent(alone.median), in_percent(alone.max));
  print_result("largest distance of a tool from its point in the field: {:.1e} m; {}\n", report.largest_residual_m,
               duration(report.seconds));
}

void print_conditions(const Scene& scene, const ValidationReport& report) {
  const double K_mu = scene.material.bulk_to_shear();
  const Element element = scene.solver.element;
  std::string nodes;
  constexpr std::size_t most_named = 20;
  for (std::size_t i = 0; i < std::min(most_named, report.nodes.size()); ++i)
    nodes += (nodes.empty() ? "" : " ") + std::to_string(report.nodes[i]);
  if (report.nodes.size() > most_named) nodes += " ...";
  print_result("{} ({}), {}, K/mu = {:.4g}{}, {} probes, R = {:.4g} mm\n", scene.title.empty() ? "scene" : scene.title,
               name(scene.material.law), name(element), K_mu,
               expected_force_ratio(scene) > warned_force_ratio ? " (locked)" : "", name(scene.probe.kind),
               1e3 * scene.probe.max_displacement_m);
  const auto [nearest, farthest] = std::ranges::minmax(report.fixed_distance_m);
  print_result("{} probes at {} nodes ({}), {:.3g} to {:.3g} mm from the nearest fixed node\n", report.probes,
               report.nodes.size(), nodes, 1e3 * nearest, 1e3 * farthest);
}

}  // namespace

void print_validation(const Validated& v) {
  for (const auto& line : verdict(v)) print_result("{}: {}.\n", line.title, line.sentence);
  for (const auto& worse : worse_than_linear(v)) print_result("warning: {}\n", worse.sentence());
  for (const auto& part : v.not_done()) print_result("{}\n", part);
  print_cells(summary_cells(v));
}

void print_details(const Validated& v, int ranks) {
  const auto& report = v.report;
  const Model& model = v.model.model();
  print_conditions(v.scene, report);
  print_table(report);
  print_to_range(report.to_range);
  print_result("{}\n", sentence(trained_share(model), model));
  print_summary(report);
  print_examples(report);
  if (v.points.finished > 0) print_points(v.points);
  if (v.pairs.finished > 0) print_pairs(v.pairs);
  print_result("runtime on this machine, one core: force {:.2f} us", report.speed.force_us);
  if (report.of(Predictor::model).inside.displacement.n > 0)
    print_result(", deformation of {} nodes {:.1f} us", model.output.size(), report.speed.deformation_us);
  if (!model.fields.empty()) print_result(", a field {:.1f} us", report.speed.field_us);
  print_result("\n");
  print_result("{} on {} rank{}\n", duration(report.seconds), ranks, ranks == 1 ? "" : "s");
}

}  // namespace phynness::cli
