#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/several_tools.hpp>

#include "reduce_command.hpp"

namespace phynness::cli {
namespace {

/// States of which there are modes, half of them of near tools, which are off most, and independent ones with which
/// bodies are compared (docs/decisions/reduced-body.md).
constexpr ToolDraws drawn{80, 40, 58'001}, compared_draws{60, 12, 58'002};
constexpr double near_radii = 1.5;
/// A larger body must be better by this factor.
constexpr double better = 0.9;

std::string in_percent(const ErrorStatistics& errors) {
  return errors.n == 0 ? "-"
                       : fmt::format("{:.3g}/{:.3g}/{:.3g}", 100 * errors.mean, 100 * errors.p95, 100 * errors.max);
}

void print_size(const ReductionReport& report, const ToolErrors& errors) {
  print_result("{:>5} {:>6}  {:>17} {:>17} {:>17}  {:.3g} ms\n", report.modes, report.cells, in_percent(errors.pairs),
               in_percent(errors.triples), in_percent(errors.near), 1e3 * errors.step_s);
}

}  // namespace

std::optional<Reduced> reduced(const std::filesystem::path& database, const ReductionSpec& spec,
                               std::optional<double> target) {
  std::vector<SolvedTools> solved, compared;
  {
    const SolverSession session;  // whose other ranks end here
    DatabaseHeader header;
    session.together([&] { reducible_scene(header = read_database_header(database)); });
    Progress progress("reduce", "states of several tools");
    ToolDraws draws = drawn;
    draws.half_within_m = near_radii * stored_scene(header).probe.tool_radius_m;
    const auto n_drawn = draws.pairs + draws.triples, n_compared = compared_draws.pairs + compared_draws.triples;
    solved = solve_several_tools(session, header, draws,
                                 [&](std::int64_t done, std::int64_t) { progress.update(done, n_drawn + n_compared); });
    compared = solve_several_tools(session, header, compared_draws, [&](std::int64_t done, std::int64_t) {
      progress.update(n_drawn + done, n_drawn + n_compared);
    });
    if (session.rank() > 0) return std::nullopt;
  }
  Progress progress("reduce", "steps");
  Reduced best;
  double error = 0;
  print_result(
      "errors of forces, mean/p95/largest in %, of {} states\nmodes  cells          two tools       three tools "
      "       near tools  a step\n",
      compared.size());
  ReductionReport report;
  reduce(Database::open(database), fields_of(solved), spec, report, progress.counter(), 0,
         [&](const ReducedBody& body, const ReductionReport& now) {
           const auto errors = tool_errors(body, compared);
           print_size(now, errors);
           const bool is_better = best.sizes.empty() || errors.pairs.p95 < better * error;
           best.sizes.push_back(record("modes", now.modes, "cells", now.cells, "errors", errors));
           if (is_better) {
             best.body = body;
             best.report = now;
             error = errors.pairs.p95;
           }
           return !target || error <= *target || !is_better;
         });
  best.report.seconds = report.seconds;
  if (target && error > *target)
    message(
        "warning: forces of two tools are off by {:.3g} % (p95), and larger bodies are hardly better; {:.3g} % were "
        "wanted\n",
        100 * error, 100 * *target);
  return best;
}

}  // namespace phynness::cli
