#include <fmt/core.h>

#include <cmath>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "query_table.hpp"
#include "streams.hpp"

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
  return {stored_scene(header), header.mesh, header.sets};
}

double smallest_in(const Mesh& mesh) {
  return smallest_displacement((mesh.nodes.colwise().maxCoeff() - mesh.nodes.colwise().minCoeff()).norm());
}

/// @param option  that gave the displacement, for messages
void refuse_tiny(const Vec3& d, double smallest, const std::string& option) {
  if (d == Vec3{0, 0, 0} || std::hypot(d[0], d[1], d[2]) >= smallest) return;
  throw input_error(
      "a displacement is too small for double precision",
      fmt::format("{}{:g},{:g},{:g}, the smallest is {:.3g} m in this body", option, d[0], d[1], d[2], smallest),
      "displacements are in metres");
}

/// Solves the rows of a file of queries, each from rest. A failed row has its reason in the column `note`.
class RowSolver {
 public:
  RowSolver(ProbeSolver& solver, int increments) : _solver(solver), _increments(increments) {}

  /// Rows of one node that follow each other share its stiffness at rest. Empty: the user wants an end.
  std::optional<std::string> answer(const Query& query) try {
    if (_touched != query.node) {
      _touched.reset();
      _solver.touch({query.node});
      _touched = query.node;
    }
    const auto response = _solver.solve({query.displacement_m}, _increments);
    if (response.status != Status::converged)
      return failed(response.status, fmt::format("{}: {}", name(response.status), meaning(response.status)));
    const auto& f = response.force_N[0];
    const auto text = fmt::format(",{},{},{},{},0,", f[0], f[1], f[2], response.energy_J);
    if (response.negative_pivots == 0) return text;
    ++_unstable;
    return text + fmt::format("unstable: {} negative pivots", response.negative_pivots);
  } catch (const Interrupted&) {
    return std::nullopt;
  } catch (const std::exception& error) {
    _touched.reset();
    recover();
    return failed(Status::library_error, error.what());
  }
  void say_what_failed() const {
    if (_failed > 0) message("warning: rows without a solution: {}; their column note says why\n", _failed);
    if (_unstable > 0) message("warning: unstable rows, whose results may depend on the path: {}\n", _unstable);
  }

 private:
  void recover() try { _solver.recover(); } catch (const std::exception&) {  // touch() tries again
  }

  /// The reason is quoted, as CSV requires it for commas.
  std::string failed(Status status, std::string reason) {
    ++_failed;
    reason = reason.substr(0, reason.find('\n'));
    for (std::size_t at = 0; (at = reason.find('"', at)) != std::string::npos; at += 2) reason.insert(at, 1, '"');
    return fmt::format(",,,,,{},\"{}\"", static_cast<int>(status), reason);
  }

  ProbeSolver& _solver;
  int _increments;
  std::optional<std::int32_t> _touched;
  std::int64_t _failed = 0, _unstable = 0;
};

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
    refuse_tiny(query.displacement_m, smallest, "");
  };
  answers.answer = [&](const Query& query) { return rows.answer(query); };
  answer_queries(options.queries, answers);
  rows.say_what_failed();
}

void run(const Options& options) {
  const auto displacements = options.tool.parsed_displacements();
  const SolverSession session;
  const auto loaded = load_source(options.source);
  for (const auto& d : displacements) refuse_tiny(d, smallest_in(loaded.mesh), "--displacement ");
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
  ToolResult result;
  for (const auto& f : response.force_N) result.force_N.emplace_back(f);
  result.energy_J = response.energy_J;
  result.nodes = loaded.sets.output;
  result.displacement_m.resize(static_cast<Eigen::Index>(result.nodes.size()), 3);
  for (std::size_t i = 0; i < result.nodes.size(); ++i)
    result.displacement_m.row(static_cast<Eigen::Index>(i)) = response.displacement_m.row(result.nodes[i]);
  for (std::size_t f = 0; f < loaded.scene.database.fields.size(); ++f) {
    const auto field = loaded.scene.database.fields[f];
    Eigen::VectorXd values(static_cast<Eigen::Index>(result.nodes.size()));
    for (std::size_t i = 0; i < result.nodes.size(); ++i)
      values[static_cast<Eigen::Index>(i)] = response.fields(result.nodes[i], static_cast<Eigen::Index>(f));
    result.fields.push_back({name(field), unit(field), column(field), std::move(values)});
  }
  json extra{{"newton_iterations", response.iterations},
             {"cutbacks", response.cutbacks},
             {"negative_pivots", response.negative_pivots},
             {"min_jacobian", response.min_jacobian}};
  if (options.tangent) {
    json rows = json::array();
    for (Eigen::Index i = 0; i < response.tangent_N_per_m.rows(); ++i) {
      json row = json::array();
      for (Eigen::Index j = 0; j < response.tangent_N_per_m.cols(); ++j) row.push_back(response.tangent_N_per_m(i, j));
      rows.push_back(row);
    }
    extra["tangent_N_per_m"] = rows;
  }
  report_tools(options.tool, places, displacements, loaded.mesh, result, extra);
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("solve", "Compute force and deformation by one finite element solve");
  add_path(*command, "SCENE", options->source, InputKind::whole,
           "scene file, or database.h5, which contains a scene and a mesh")
      ->required();
  options->tool.add_to(*command);
  options->queries.add_to(*command);
  command
      ->add_option("--increments", options->increments,
                   "number of equal steps to the displacement (default: that of the scene)")
      ->check(CLI::Range(1, 1000));
  command->add_flag("--tangent", options->tangent, "add the condensed stiffness dF/dd [N/m] to the JSON output");
  command->callback([options] {
    options->queries.check(options->tool, options->tangent ? "--tangent" : "");
    options->queries.file ? run_queries(*options) : run(*options);
  });
}

}  // namespace phynness::cli::solve_command
