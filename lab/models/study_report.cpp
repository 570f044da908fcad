#include "study_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>

namespace phynness::study {

using nlohmann::json;

namespace {

json to_json(const ErrorStatistics& s) {
  if (s.n == 0) return nullptr;
  return {{"median", s.median}, {"mean", s.mean}, {"p95", s.p95}, {"max", s.max}, {"n", s.n}};
}
json to_json(const GroupErrors& e) {
  return {{"force", to_json(e.force)}, {"displacement", to_json(e.displacement)}, {"field_l2", to_json(e.field_l2)}};
}

void print_modal_head() {
  fmt::print("\n{:<38} {:>13} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "family modal", "force shapes",
             "ampl.", "cancels", "condition", "cond.", "float32", "float32", "loop work", "loop work");
  fmt::print("{:<38} {:>13} {:>7} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "", "", "shape", "by", "force", "ampl.",
             "mean", "max", "double", "float32");
}

}  // namespace

void print_errors(const std::string& name, const PredictorErrors& all, const PredictorErrors& calm,
                  const std::vector<std::array<double, 2>>& by_node) {
  const auto percent = [](const ErrorStatistics& s, double value) {
    if (s.n == 0)
      fmt::print(" {:>7}", "-");
    else
      fmt::print(" {:7.{}f}", 100 * value, 100 * value >= 100 ? 0 : 2);
  };
  fmt::print("{:<44} |", name);
  for (const auto* s : {&all.inside.force, &all.inside.displacement}) {
    for (const double value : {s->median, s->mean, s->p95, s->max}) percent(*s, value);
    fmt::print(" |");
  }
  for (const auto* s : {&all.outside.force, &all.outside.displacement}) percent(*s, s->mean);
  fmt::print(" |");
  for (const auto* s : {&calm.inside.force, &calm.inside.displacement, &calm.outside.force, &calm.outside.displacement})
    percent(*s, s->mean);
  fmt::print(" |");
  for (const std::size_t k : {0, 1}) {
    std::vector<double> means;
    for (const auto& node : by_node) means.push_back(node[k]);
    percent(all.inside.force, ErrorStatistics::of(means).median);
  }
  fmt::print("\n");
  std::fflush(stdout);
}

void print_head() {
  fmt::print("{:<44} | {:^31} | {:^31} | {:^15} | {:^31} | {:^15}\n", "errors of eq. (17) in %", "force inside",
             "displacement inside", "means beyond", "means, without nodes that snap", "mean, med. node");
  fmt::print("{:<44} |", "");
  for (int i = 0; i < 2; ++i) fmt::print(" {:>7} {:>7} {:>7} {:>7} |", "median", "mean", "p95", "max");
  fmt::print(" {:>7} {:>7} | {:>7} {:>7} {:>7} {:>7} | {:>7} {:>7}\n", "force", "displ.", "f in", "u in", "f out",
             "u out", "force", "displ.");
}

void print_row(const Row& row) {
  if (!row.refused.empty()) {
    fmt::print("{:<44} | refused: {}\n", row.family + " " + row.name, row.refused);
    return;
  }
  print_errors(row.family + " " + row.name + (row.finite ? "" : " (not finite)"), row.all, row.calm, row.by_node);
}

void print_numbers(const std::vector<Row>& rows) {
  const bool modal = std::any_of(rows.begin(), rows.end(), [](const Row& r) { return r.family == "modal"; });
  if (modal) print_modal_head();
  for (const auto& r : rows)
    if (r.family == "modal" && r.refused.empty())
      fmt::print("{:<38} {:>13} {:7.3g} {:9.1e} {:9.1e} {:9.1e} {:9.1e} {:9.1e} {:9.1e} {:9.1e}\n", r.name,
                 fmt::format("{:.3g}-{:.3g}", r.smallest_shape, r.largest_shape), r.amplitude_shape, r.cancellation,
                 r.force_condition, r.amplitude_condition, r.single.force_mean, r.single.force_max,
                 r.single.loop_double, r.single.loop_float);
  for (const auto& r : rows)
    if (r.family == "rbfn" && r.refused.empty())
      fmt::print("{:<38} largest over smallest diagonal entry of the factor {:.1e}\n", "rbfn " + r.name,
                 r.diagonal_ratio);
}

void print_parts(const std::string& name, const std::vector<ErrorParts>& parts, const std::vector<char>& snaps) {
  fmt::print("\nfamily modal, {}: parts of the means inside, %\n", name);
  fmt::print("{:<8} {:>6} {:>9} | {:^26} | {:^44} | {:>9}\n", "", "", "", "force", "displacement", "runtime");
  fmt::print("{:<8} {:>6} {:>9} | {:>8} {:>8} {:>8} | {:>8} {:>8} {:>8} {:>8} {:>8} | {:>9}\n", "node", "to fix.",
             "largest", "regress.", "interp.", "total", "truncat.", "regress.", "ampl.", "interp.", "total", "float");
  fmt::print("{:<8} {:>6} {:>9} |\n", "", "mm", "N");
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& p = parts[i];
    fmt::print(
        "{:<8} {:6.1f} {:9.3g} | {:8.3f} {:8.3f} {:8.3f} | {:8.3f} {:8.3f} {:8.3f} {:8.3f} {:8.3f} | "
        "{:9.1e}\n",
        fmt::format("{}{}", p.node, snaps[i] ? " *" : ""), 1e3 * p.distance_to_fixed_m, p.largest_force_N,
        100 * p.force_regression, 100 * p.force_interpolation, 100 * p.force_total, 100 * p.truncation,
        100 * p.regression, 100 * p.amplitudes, 100 * p.interpolation, 100 * p.total, p.float_rounding);
  }
  fmt::print("* snaps: largest force more than {} times the median active node's\n", snap_ratio);
}

json to_json(const PredictorErrors& e) { return {{"inside", to_json(e.inside)}, {"outside", to_json(e.outside)}}; }
json to_json(const Row& r) {
  json out{{"family", r.family}, {"row", r.name}};
  if (!r.refused.empty()) {
    out["refused"] = r.refused;
    return out;
  }
  out["finite"] = r.finite;
  out["all"] = to_json(r.all);
  out["without_snaps"] = to_json(r.calm);
  out["means_by_node"] = r.by_node;
  if (r.family == "rbfn") {
    out["diagonal_ratio"] = r.diagonal_ratio;
    return out;
  }
  out["force_shapes"] = {r.smallest_shape, r.largest_shape};
  out["amplitude_shape"] = r.amplitude_shape;
  out["cancellation"] = r.cancellation;
  out["condition_force"] = r.force_condition;
  out["condition_amplitudes"] = r.amplitude_condition;
  out["float32_force_mean"] = r.single.force_mean;
  out["float32_force_max"] = r.single.force_max;
  out["loop_work_double"] = r.single.loop_double;
  out["loop_work_float32"] = r.single.loop_float;
  return out;
}
json to_json(const ErrorParts& p) {
  return {{"node", p.node},
          {"distance_to_fixed_m", p.distance_to_fixed_m},
          {"largest_force_N", p.largest_force_N},
          {"force_regression", p.force_regression},
          {"force_interpolation", p.force_interpolation},
          {"force_total", p.force_total},
          {"truncation", p.truncation},
          {"regression", p.regression},
          {"amplitudes", p.amplitudes},
          {"interpolation", p.interpolation},
          {"total", p.total},
          {"float_rounding", p.float_rounding}};
}

}  // namespace phynness::study
