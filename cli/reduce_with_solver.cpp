#include <algorithm>
#include <chrono>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/several_tools.hpp>
#include <thread>

#include "reduce_command.hpp"

namespace phynness::cli {
namespace {

/// The states that give modes, half of them with near tools, which have the largest errors, and the independent states
/// with which bodies are compared (docs/decisions/reduced-body.md).
constexpr ToolDraws mode_draws{.pairs = 80, .triples = 40, .seed = 58'001, .half_at_probed = true},
    compared_draws{.pairs = 60, .triples = 12, .seed = 58'002};
/// Scenes of three tools or more have more states of three.
constexpr int more_triples_for_modes = 3, more_triples_compared = 8;
ToolDraws for_tools(ToolDraws draws, int tools) {
  if (tools > 2) draws.triples *= draws.half_at_probed ? more_triples_for_modes : more_triples_compared;
  return draws;
}
constexpr double near_radii = 1.5;
/// Of the modes and weights of the first body, by one core; measured: 14 s for 2,483 points, 17 s for 3,188.
constexpr double reduction_s_per_point = 5.5e-3;
/// Weights of three tools are fitted twice, the second time to more states; measured: 15.1 s instead of 6.5 s.
constexpr double reduction_of_triples = 2.3;

std::string in_percent(const ErrorStatistics& errors) {
  return errors.n == 0 ? "-"
                       : fmt::format("{:.3g}/{:.3g}/{:.3g}", 100 * errors.mean, 100 * errors.p95, 100 * errors.max);
}

void print_size(const ReductionReport& report, const ToolErrors& errors) {
  print_result("{:>5} {:>6}  {:>17} {:>17} {:>17}  {:.3g} ms\n", report.modes, report.cells, in_percent(errors.pairs),
               in_percent(errors.triples), in_percent(errors.near), 1e3 * errors.step_s);
}

}  // namespace

double reduction_s(double increment_s, std::int64_t points, int tools, int ranks) {
  const double solved = increments_of(for_tools(mode_draws, tools)) + increments_of(for_tools(compared_draws, tools));
  const int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const double point_s = reduction_s_per_point * (tools > 2 ? reduction_of_triples : 1);
  return solved * increment_s / ranks + point_s * static_cast<double>(points) / threads;
}

std::optional<Reduced> reduced(const std::filesystem::path& database, const ReductionSpec& spec,
                               std::optional<double> target, int tools) {
  const auto start = std::chrono::steady_clock::now();
  const SolverSession session;
  DatabaseHeader header;
  session.together([&] { reducible_scene(header = read_database_header(database)); });
  if (tools == 0) tools = stored_scene(header).probe.tools;
  const auto solve = [&](ToolDraws draws) {
    // Near triples have so small a weight that half of the compared states would say nothing.
    if (tools <= 2 || draws.half_at_probed) draws.half_within_m = near_radii * stored_scene(header).probe.tool_radius_m;
    return solve_several_tools(session, header, draws, Progress("reduce", "states of several tools").counter());
  };
  ToolDraws draws = for_tools(compared_draws, tools);
  auto solved = solve(for_tools(mode_draws, tools));
  auto compared = solve(draws);
  const auto solve_more = [&] {
    ++draws.seed;
    return solve(draws);
  };
  if (session.rank() > 0) {
    while (session.broadcast(false)) solve_more();
    return std::nullopt;
  }
  const struct End {
    const SolverSession& session;
    ~End() { session.broadcast(false); }
  } end{session};
  Progress progress("reduce", "steps");
  Reduced best;
  double error = 0;
  print_result(
      "errors of forces, mean/p95/largest in %, of {} states where the body answers without a warning\n"
      "modes  cells          two tools       three tools        near tools  a step\n",
      compared.size());
  OwnStates own_states;
  if (tools > 2) own_states = [&](const ReducedBody& made) { return displacements_under(made, solved); };
  ReductionReport report;
  reduce(
      Database::open(database), fields_of(solved), spec, report, progress.counter(), 0,
      [&](const ReducedBody& made, const ReductionReport& current, Eigen::MatrixXd& fields) {
        auto body = made;
        auto errors = tool_errors(body, compared, Progress("reduce", "compared states").counter());
        const double with_rest = target_error(errors, tools);
        const bool has_lost = target && leave_out_at_rest(body, errors, compared, *target, tools,
                                                          Progress("reduce", "compared states").counter());
        print_size(current, errors);
        if (has_lost)
          print_result("these without the tables at rest, with which the error is {:.3g} %\n", 100 * with_rest);
        const bool is_better = best.sizes.empty() || target_error(errors, tools) < required_improvement * error;
        best.sizes.push_back(record("modes", current.modes, "cells", current.cells, "has_tables_at_rest",
                                    body.cells_at_rest.entries.size() > 0, "errors", errors));
        if (is_better) {
          best.body = body;
          best.report = current;
          error = target_error(errors, tools);
        }
        if (!target || error <= *target || !is_better) return true;
        // The next body has modes of the states that this one has not met, too, and is compared with others.
        session.broadcast(true);
        const auto extra_fields = fields_of(compared);
        fields.conservativeResize(Eigen::NoChange, fields.cols() + extra_fields.cols());
        fields.rightCols(extra_fields.cols()) = extra_fields;
        // The kept body is compared with all states that have given it no modes.
        const auto n_met = std::ssize(compared);
        auto others = solve_more();
        compared.insert(compared.end(), others.begin(), others.end());
        error = target_error(tool_errors(best.body, compared, Progress("reduce", "compared states").counter()), tools);
        solved.insert(solved.end(), compared.begin(), compared.begin() + n_met);
        compared = std::move(others);
        return false;
      },
      own_states);
  best.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (target && error > *target)
    message(
        "warning: the force error of two tools is {:.3g} % (the largest of p95, a third of the maximum and 2.5 times "
        "the mean{}), and larger bodies are less than a tenth better; {:.3g} % were wanted (--target-error)\n",
        100 * error, tools > 2 ? ", and half of p95 of three tools" : "", 100 * *target);
  return best;
}

}  // namespace phynness::cli
