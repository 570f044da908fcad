#include <algorithm>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/sizes.hpp>
#include <phynness/validation/tools.hpp>

#include "commands.hpp"

namespace phynness::cli::validate_command {
namespace {

/// Equation (17) divides by the largest response of a point. With a single displacement per point it would divide a
/// response by itself.
constexpr std::int64_t displacements_per_point = 4;
/// Probes at nodes per point of a round tool between nodes; the default of --points.
constexpr std::int64_t probes_per_point = 12;

struct Options {
  std::filesystem::path scene, model;
  std::optional<std::int64_t> probes, points, seed;
  std::int64_t nodes = 0, pairs = 0, motions = 0;
  std::optional<std::int32_t> level;
  OptionalPath body, json_file, report_file;
};

/// Loads scene, model and body on every rank and checks them on the first.
Validated load(const Options& options, const SolverSession& session) {
  Scene scene;
  std::optional<NamedOrgan> loaded;
  std::optional<NamedOrgan> body;
  session.together([&] {
    scene = open_scene(options.scene);
    loaded.emplace(options.model);
    if (options.level) loaded->set_level(*options.level);
    if (options.body) {
      body = NamedOrgan::body(*options.body);
      loaded->require_same("the body " + body->name(), body->body_info().mesh_hash, body->body_info().physics_hash);
    }
    if (options.pairs > 0 && !body && loaded->has_round_tools())
      throw input_error("--pairs needs a body: a model of round tools answers one tool", options.model.string(),
                        several_round_tools);
    if (session.rank() == 0) check_mesh(scene, loaded->model().mesh_hash, options.model.string());
  });
  const auto seed = options.seed ? static_cast<std::uint64_t>(*options.seed) : scene.validation.seed;
  Validated v{std::move(scene), std::move(*loaded), seed};
  v.body = std::move(body);
  return v;
}

/// @throws Error (input) if the model has forces only
void require_deformations(const Options& options, const NamedOrgan& model) {
  if (!model.model().nodes.empty() &&
      model.blend({model.model().nodes.front().node}, {Vec3{}}).displacement_m.rows() == 0)
    throw input_error("coupled tools need deformations, but the model has forces only", options.model.string(),
                      "omit --points and --pairs, or train the model with modes");
}

/// Runs a part of the validation. @return its error, if any
template <class Part>
std::optional<Error> try_part(const Part& part) {
  try {
    part();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

/// The header of the database on which a model of the scene was trained.
DatabaseHeader header_of(const Scene& scene, const NamedOrgan& model) {
  NodeSets sets{model.model().fixed, {}, model.model().output};
  for (const auto& node : model.model().nodes) sets.active.push_back(node.node);
  return database_header(scene, model.mesh(), sets);
}

void measure(const Options& options, const SolverSession& session, Validated& v) {
  const auto& scene = v.scene;
  const auto& model = v.model;
  const NamedOrgan* const body = v.body ? &*v.body : nullptr;
  const bool bounded = !schema::traits(model.model().family).proportional;
  const auto probes = options.probes.value_or(sizes_of_checks(scene, header_of(scene, model), bounded).probes);
  v.report = validate(session, scene, model, probes, v.seed, Progress("validate", "rays").counter(), stop_requested,
                      options.nodes);
  const auto points = options.points.value_or(model.has_round_tools() ? probes / probes_per_point + 1 : 0);
  if (points > 0 && !v.interrupted()) {
    const auto failed = try_part([&] {
      require_deformations(options, model);
      const auto validate_part = [&](SurfacePart part, std::int64_t n) {
        return validate_points(session, scene, model, body, part, n, displacements_per_point, v.seed,
                               Progress("validate", "points").counter(), stop_requested);
      };
      v.points = validate_part(SurfacePart::probed, points);
      if (model.has_round_tools() && !v.interrupted()) v.rim = validate_part(SurfacePart::rim, (points + 1) / 2);
    });
    if (options.points) v.no_points = failed;
  }
  if (options.pairs > 0 && !v.interrupted())
    v.no_pairs = try_part([&] {
      require_deformations(options, model);
      v.pairs = validate_pairs(session, scene, model, body, options.pairs,
                               pair_depth_fraction * scene.probe.max_displacement_m, v.seed,
                               Progress("validate", "pairs").counter(), stop_requested);
    });
  if (options.motions > 0 && !v.interrupted())
    v.motions = validate_motions(session, scene, model, body, options.motions, v.seed,
                                 Progress("validate", "places in motion").counter(), stop_requested);
}

/// @throws Error (failure)
void throw_interrupted(const Options& options, const Validated& v) {
  std::string finished = fmt::format("{} of {} rays", v.report.rays_finished, v.report.rays);
  if (const auto points = options.points.value_or(v.points.points); points > 0)
    finished += fmt::format(", {} of {} points", v.points.finished, points);
  if (options.pairs > 0) finished += fmt::format(", {} of {} pairs", v.pairs.finished, options.pairs);
  if (options.motions > 0) finished += fmt::format(", {} of {} places in motion", v.motions.finished, options.motions);
  throw failure("validate was interrupted; the figures above are those of the finished part", finished,
                fmt::format("run it again; --seed {} repeats the same probes{}", v.seed,
                            options.report_file ? "; the report was not written" : ""));
}

void write_report(const Options& options, const Validated& v) {
  if (!options.report_file || v.interrupted()) return;
  write_text_file(*options.report_file, html_report(v, software_version()));
  print_result("report: {}\n", options.report_file->string());
}

/// Prints a table with the first column left-aligned and the others right-aligned.
void print_cells(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  for (const auto& row : rows) {
    std::string line = fmt::format("{:<{}}", row[0], widths[0]);
    for (std::size_t i = 1; i < row.size(); ++i) line += fmt::format("  {:>{}}", row[i], widths[i]);
    print_result("{}\n", line.erase(line.find_last_not_of(' ') + 1));
  }
}

/// Prints the verdict, the omitted parts and the tables.
void print(const Validated& v) {
  for (const auto& line : verdict(v)) print_result("{}: {}.\n", line.title, line.sentence);
  for (const auto& warning : warnings(v)) print_result("warning: {}\n", warning);
  for (const auto& part : v.not_done()) print_result("{}\n", part);
  print_cells(summary_cells(v));
  if (v.motions.finished > 0) print_cells(v.motions.cells());
}

void run(const Options& options) {
  if (options.body && options.points == 0 && options.pairs == 0 && options.motions == 0)
    throw input_error("--body is compared at tools of --points, --pairs and --relaxation only", options.body->string(),
                      "add one of these options, or omit --body");
  const SolverSession session;
  Validated v = load(options, session);
  install_stop_handler();
  measure(options, session, v);
  if (session.rank() != 0) return;
  print(v);
  write_each({[&] { write_json(options.json_file, validation_figures(v)); }, [&] { write_report(options, v); }});
  if (v.interrupted()) throw_interrupted(options, v);
  const auto& reason = v.no_points ? v.no_points : v.no_pairs;
  if (!reason) return;
  const char* parts = !v.no_pairs ? "--points was" : !v.no_points ? "--pairs was" : "--points and --pairs were";
  throw Error(reason->kind(), fmt::format("{} not done; everything else was", parts), reason->what(), "");
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] = add_command(app, "validate", "Compare a model with fresh finite element solves", run);
  add_scene(command, options.scene, "scene from which the model was made");
  add_model(command, options.model);
  add_count(command, "--probes", options.probes, 1, 10'000'000,
            "number of probes, inside and outside of the trained range (default: validation.probes of the scene)");
  add_count(command, "--nodes", options.nodes, 1, 10'000'000,
            "number of probed active nodes (default: a twentieth of the probes, at least 10)");
  add_count(
      command, "--points", options.points, 0, 1'000'000,
      "also compare tools at this number of random points between nodes, and round tools at half as many where only\n"
      "one or two corners of a triangle were probed (default: a twelfth of the probes and one for round tools, "
      "otherwise none)");
  add_count(
      command, "--pairs", options.pairs, 1, 1'000'000,
      "also compare two tools at this number of random pairs of nodes, by solves with both tools, each as deep\nas " +
          std::string(pair_depth_in_words) + " of the scene's max_displacement_m (12 mm of 28 mm in the paper)");
  add_count(command, "--relaxation", options.motions, 1, 1'000'000,
            "also compare relaxing forces at this number of random places with solves in time: step and hold, ramp,\n"
            "sine, palpation and slide, to 5 mm and to the full depth; with --body two tools, too");
  add_path(command, "--body", options.body, PathKind::input,
           "a reduced body (body.txt), whose forces are also compared at --points and --pairs; pairs of round tools "
           "need one");
  command.add_option("--level", options.level, "level of the model; 0 is the smallest (default: the full one)");
  add_count(command, "--seed", options.seed, 0, largest_seed, "seed of random directions, magnitudes and nodes");
  add_json(command, options.json_file);
  add_path(command, "--report", options.report_file, PathKind::file, "write an HTML report with curves and pictures");
}

}  // namespace phynness::cli::validate_command
