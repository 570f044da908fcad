// The errors of a report.
#include <fmt/core.h>

#include "blocks.hpp"

namespace phynness {

using namespace report;

namespace {

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
    rows.push_back({title + (outside ? ", outside" : ", inside"), in_percent(m.mean), in_percent(m.median),
                    in_percent(m.p95), in_percent(m.max), in_percent(l.mean), in_percent(l.p95), in_percent(l.max),
                    in_percent(z.mean)});
  }
}

/// Tools between nodes, of which the table of the verdict has the model's errors over unflagged forces.
Json points_table(const PointReport& report) {
  std::vector<std::pair<const char*, const PointErrors*>> predictors{{"model", &report.coupled},
                                                                     {"linear predictor", &report.linear}};
  if (report.body) predictors.emplace_back("reduced body", &*report.body);
  Rows rows{{"between nodes, in %", "mean", "median", "p95", "max"}};
  for (std::size_t i = 0; i < titled(PointErrors{}).size(); ++i)
    for (const auto& [who, errors] : predictors) {
      const auto [what, s] = titled(*errors)[i];
      rows.push_back({fmt::format("{}, {}", what, who), in_percent(s.mean), in_percent(s.median), in_percent(s.p95),
                      in_percent(s.max)});
    }
  return table(rows);
}

void add_counts(const std::string& who, const AnswerCounts& counts, std::vector<Json>& blocks) {
  std::string words =
      fmt::format("{}: {} unsettled, {} outside of the trained range, {} of tools too near to each other", who,
                  counts.unsettled, counts.outside, counts.near);
  if (counts.bounded > 0)
    words += fmt::format("; {} of {} errors of forces are below their bound", counts.covered, counts.bounded);
  blocks.push_back(text(words + "."));
}

}  // namespace

Json error_section(const Validated& in) {
  Rows rows{{"error in %", "model: mean", "median", "p95", "max", "linear: mean", "p95", "max", "zero: mean"}};
  for (const bool outside : {false, true}) add_rows(in, outside, rows);
  std::vector<Json> blocks{folded("Errors inside and outside the trained range", rows)};
  if (in.points.finished > 0) {
    blocks.push_back(points_table(in.points));
    add_counts("The model between nodes", in.points.answers, blocks);
    if (in.points.body) add_counts("The reduced body between nodes", in.points.body_answers, blocks);
  }
  if (in.pairs.finished > 0)
    add_counts(
        fmt::format("{} of {} pairs of tools, both {:.4g} mm deep", in.pairs.by_body ? "The reduced body" : "The model",
                    in.pairs.finished, 1e3 * in.pairs.depth_m),
        in.pairs.answers, blocks);
  return section("Errors", blocks);
}

}  // namespace phynness
