#include <cmath>
#include <phynness/precompute/probe_solver.hpp>
#include <utility>

#include "commands.hpp"
#include "query_table.hpp"

namespace phynness::cli::solve_command {
namespace {

struct Options {
  std::filesystem::path source;
  std::optional<int> increments;
  bool tangent = false;
  ToolOptions tool;
  QueryOptions queries;
};

LoadedScene load_source(const std::filesystem::path& source) {
  if (source.extension() != ".h5" && source.extension() != ".hdf5") return load_scene(source);
  const auto database = Database::open(source);
  const auto& header = database.header();
  require_scene(header);
  return {stored_scene(header), header.mesh, header.sets};
}

double smallest_in(const Mesh& mesh) {
  return smallest_displacement((mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm());
}

/// @param option  option of the displacement, for messages
void require_resolvable(const Vec3& d, double smallest, const std::string& option) {
  if (d == Vec3{0, 0, 0} || std::hypot(d[0], d[1], d[2]) >= smallest) return;
  throw input_error(
      "a displacement is too small for double precision",
      fmt::format("{}{:g},{:g},{:g}, the smallest is {:.3g} m in this body", option, d[0], d[1], d[2], smallest),
      "displacements are in metres");
}

/// Solves the rows of a file of queries, each from rest. The column `note` has the reason of a failed row.
class RowSolver {
 public:
  RowSolver(ProbeSolver& solver, int increments) : _solver(solver), _increments(increments) {}

  /// Consecutive rows of a node share its stiffness at rest. Empty after a stop request.
  std::optional<std::string> answer(const Query& query) try {
    if (_touched_node != query.node) {
      _touched_node.reset();
      _solver.touch({query.node});
      _touched_node = query.node;
    }
    const auto response = _solver.solve({query.displacement_m}, _increments);
    if (response.status != Status::converged)
      return failed_row(response.status, fmt::format("{}: {}", name(response.status), meaning(response.status)));
    const auto& f = response.force_N[0];
    const auto text = fmt::format(",{},{},{},{},0,", f[0], f[1], f[2], response.energy_J);
    if (response.negative_pivots == 0) return text;
    ++_n_unstable;
    return text + fmt::format("unstable: {} negative pivots", response.negative_pivots);
  } catch (const Interrupted&) {
    return std::nullopt;
  } catch (const std::exception& error) {
    _touched_node.reset();
    recover();
    return failed_row(Status::library_error, error.what());
  }
  void print_failures() const {
    if (_n_failed > 0) message("warning: rows without a solution: {}; their column note says why\n", _n_failed);
    if (_n_unstable > 0) message("warning: unstable rows, whose results may depend on the path: {}\n", _n_unstable);
  }

 private:
  void recover() try { _solver.recover(); } catch (const std::exception&) {  // touch() tries again
  }

  /// The reason is quoted, as CSV requires it for commas.
  std::string failed_row(Status status, std::string reason) {
    ++_n_failed;
    reason = reason.substr(0, reason.find('\n'));
    for (std::size_t at = 0; (at = reason.find('"', at)) != std::string::npos; at += 2) reason.insert(at, 1, '"');
    return fmt::format(",,,,,{},\"{}\"", static_cast<int>(status), reason);
  }

  ProbeSolver& _solver;
  int _increments;
  std::optional<std::int32_t> _touched_node;
  std::int64_t _n_failed = 0, _n_unstable = 0;
};

/// Solves a step of a motion from rest. @throws Error (failure) if it fails
std::optional<std::string> motion_row(ProbeSolver& solver, const Relaxation& relaxation, const Query& query,
                                      bool is_first) try {
  if (is_first) {
    solver.touch({query.node});
    solver.begin_motion(relaxation);
  }
  std::vector<Vec3> force;
  const auto status = solver.move({*query.time_s, {query.displacement_m}, {at_node(query.node)}}, force);
  if (status != Status::converged)
    throw failure(fmt::format("the motion could not be solved beyond {:g} s", *query.time_s), meaning(status),
                  "use more rows, or smaller displacements");
  return fmt::format(",{},{},{}", force[0][0], force[0][1], force[0][2]);
} catch (const Interrupted&) {
  return std::nullopt;
}

void run_queries(const Options& options) {
  const SolverSession session;
  const auto loaded = load_source(options.source);
  ProbeSolver solver(loaded.scene, loaded.mesh, loaded.sets);
  solver.set_stop(stop_requested);
  const double smallest = smallest_in(loaded.mesh);
  RowSolver rows(solver, options.increments.value_or(loaded.scene.probe.increments));
  QueryAnswers answers;
  answers.command = "solve";
  answers.columns = ",fx_N,fy_N,fz_N,energy_J,status,note";
  answers.check = [&](const Query& query) {
    solver.check_touched(query.node);
    require_resolvable(query.displacement_m, smallest, "");
  };
  answers.motion_columns = ",fx_N,fy_N,fz_N";
  bool is_first = true;
  answers.answer = [&](const Query& query) {
    if (!query.time_s) return rows.answer(query);
    return motion_row(solver, loaded.scene.relaxation, query, std::exchange(is_first, false));
  };
  answer_queries(options.queries, answers);
  rows.print_failures();
}

void run_single(const Options& options) {
  const auto displacements = options.tool.parsed_displacements();
  const SolverSession session;
  const auto loaded = load_source(options.source);
  for (const auto& d : displacements) require_resolvable(d, smallest_in(loaded.mesh), "--displacement ");
  ProbeSolver solver(loaded.scene, loaded.mesh, loaded.sets);
  const auto places = options.tool.places(loaded.mesh);
  const int increments = options.increments.value_or(loaded.scene.probe.increments);
  if (options.tool.points.empty())
    solver.touch(options.tool.nodes);
  else
    solver.touch_points(places);
  const Response response = solver.solve(displacements, increments, options.tangent);
  if (response.status != Status::converged)
    throw failure("the solve did not converge", fmt::format("{}: {}", name(response.status), meaning(response.status)),
                  "use a smaller displacement or more --increments (" + std::to_string(response.cutbacks) +
                      " cutbacks were tried)");
  if (response.negative_pivots > 0)
    message("warning: the state is unstable ({} negative pivots): the result may depend on the path\n",
            response.negative_pivots);
  const auto& output = loaded.sets.output;
  ToolResult result{{response.force_N.begin(), response.force_N.end()},
                    response.energy_J,
                    response.displacement_m(output, Eigen::all),
                    output,
                    {}};
  for (const auto field : loaded.scene.database.fields)
    result.fields.push_back(
        {name(field), unit(field), column(field), response.fields(output, std::ssize(result.fields))});
  json extra = record("newton_iterations", response.iterations, "cutbacks", response.cutbacks, "negative_pivots",
                      response.negative_pivots, "min_jacobian", response.min_jacobian);
  if (options.tangent)
    for (const auto& row : response.tangent_N_per_m.rowwise())
      extra["tangent_N_per_m"].push_back(std::vector<double>(row.begin(), row.end()));
  report_tools(options.tool, places, displacements, loaded.mesh, result, extra);
}

void run(const Options& options) { options.queries.file ? run_queries(options) : run_single(options); }

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(app, "solve", "Compute force and deformation by one finite element solve", run);
  add_scene(command, options.source, "scene file, or database.h5, which contains a scene and a mesh");
  options.tool.add_to(command);
  add_count(command, "--increments", options.increments, 1, 1000,
            "number of equal steps to the displacement (default: that of the scene)");
  command.add_flag("--tangent", options.tangent, "add the condensed stiffness dF/dd [N/m] to the JSON output");
  options.queries.add_to(command, {"--node", "--point", "--displacement", "--deformation", "--json", "--tangent"});
}

}  // namespace phynness::cli::solve_command
