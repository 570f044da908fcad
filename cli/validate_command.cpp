#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/locking.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/pages/report.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <phynness/validation/trained_share.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "error_tables.hpp"
#include "output_places.hpp"
#include "streams.hpp"

namespace phynness::cli::validate_command {
namespace {

/// Equation (17) divides by the largest response of a point. With a single displacement per point it would divide a
/// response by itself.
constexpr std::int64_t displacements_per_point = 4;

struct Options {
  std::filesystem::path scene, model;
  std::optional<std::int64_t> probes;
  std::optional<std::int64_t> seed;
  std::int64_t nodes = 0, points = 0, pairs = 0;
  std::optional<double> pair_depth_m;
  std::optional<std::int32_t> level;
  std::optional<std::filesystem::path> json_file, report_file;
  bool details = false;
};

/// Scene and model, loaded on every rank and checked by the first.
Validated load(const Options& options, const SolverSession& session) {
  Scene scene;
  std::optional<LoadedModel> loaded;
  session.together([&] {
    scene = open_scene(options.scene);
    loaded.emplace(options.model);
    if (options.level) loaded->set_level(*options.level);
    if (session.rank() == 0) check_mesh(scene, loaded->model().mesh_hash, options.model.string());
  });
  const auto seed = options.seed ? static_cast<std::uint64_t>(*options.seed) : scene.validation.seed;
  return {std::move(scene), std::move(*loaded), seed};
}

/// @throws Error (input) if the model has forces only
void require_deformations(const Options& options, const LoadedModel& model) {
  if (!model.model().nodes.empty() &&
      model.respond({model.model().nodes.front().node}, {Vec3{}}).displacement_m.rows() == 0)
    throw input_error("coupled tools need deformations, but the model has forces only", options.model.string(),
                      "omit --points and --pairs, or train the model with modes");
}

/// Does a part of the validation. @return why it cannot be done
template <class Part>
std::optional<Error> try_part(const Part& part) {
  try {
    part();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

void measure(const Options& options, const SolverSession& session, Validated& v) {
  const auto& scene = v.scene;
  const auto& model = v.model;
  {
    Progress progress("validate", "rays");
    v.report = validate(
        session, scene, model, options.probes.value_or(scene.validation.probes), v.seed,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested, options.nodes);
  }
  if (options.points > 0 && !v.interrupted()) {
    Progress progress("validate", "points");
    v.no_points = try_part([&] {
      require_deformations(options, model);
      v.points = validate_points(
          session, scene, model, options.points, displacements_per_point, v.seed,
          [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
    });
  }
  if (options.pairs > 0 && !v.interrupted()) {
    Progress progress("validate", "pairs");
    v.no_pairs = try_part([&] {
      require_deformations(options, model);
      v.pairs = validate_pairs(
          session, scene, model, options.pairs,
          options.pair_depth_m.value_or(pair_depth_fraction * scene.probe.max_displacement_m), v.seed,
          [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
    });
  }
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

void print(const Validated& v) {
  print_verdict(v);
  print_worse(worse_than_linear(v));
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

/// @throws Error (failure)
void refuse_half(const Options& options, const Validated& v) {
  std::string finished = fmt::format("{} of {} rays", v.report.rays_finished, v.report.rays);
  if (options.points > 0) finished += fmt::format(", {} of {} points", v.points.finished, options.points);
  if (options.pairs > 0) finished += fmt::format(", {} of {} pairs", v.pairs.finished, options.pairs);
  throw failure("validate was interrupted; the figures above are those of the finished part", finished,
                fmt::format("run it again; --seed {} repeats the same probes{}", v.seed,
                            options.report_file ? "; the report was not written" : ""));
}

void write_report(const Options& options, const Validated& v) {
  if (!options.report_file || v.interrupted()) return;
  write_text_file(*options.report_file, html_report(v, software_version()));
  print_result("report: {}\n", options.report_file->string());
}

void run(const Options& options) {
  if (options.report_file) report::require_page();
  const SolverSession session;
  Validated v = load(options, session);
  install_stop_handler();
  measure(options, session, v);
  if (session.rank() != 0) return;
  print(v);
  if (options.details) print_details(v, session.size());
  write_each({[&] { write_json(options.json_file, validation_figures(v)); }, [&] { write_report(options, v); }});
  if (v.interrupted()) refuse_half(options, v);
  const auto& reason = v.no_points ? v.no_points : v.no_pairs;
  if (!reason) return;
  const char* parts = !v.no_pairs ? "--points was" : !v.no_points ? "--pairs was" : "--points and --pairs were";
  throw Error(reason->kind(), fmt::format("{} not done; everything else was", parts), reason->what(), "");
}

}  // namespace

void add(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("validate", "Compare a model with fresh finite element solves");
  add_path(*command, "SCENE", options->scene, InputKind::whole, "scene from which the model was made")->required();
  add_path(*command, "MODEL_DIR", options->model, InputKind::whole, "directory with model.txt and mesh.txt")
      ->required();
  command->add_option("--probes", options->probes, "number of probes, inside and outside of the trained range")
      ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--nodes", options->nodes,
                   "number of probed active nodes (default: a twentieth of the probes, at least 10)")
      ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--points", options->points,
                   "also compare tools at this number of random points between nodes, by point-constrained solves")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--pairs", options->pairs,
                   "also compare two tools at this number of random pairs of nodes, by solves with both tools")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option("--pair-depth", options->pair_depth_m,
                   "displacement of both tools of a pair [m] (default: 3/7 of the scene's max_displacement_m, as in\n"
                   "the paper, 12 mm of 28 mm)")
      ->check(finite_range(1e-12, 1e3));
  command->add_option("--level", options->level, "level of the model; 0 is the smallest (default: the full one)");
  command->add_option("--seed", options->seed, "seed of random directions, magnitudes and nodes")
      ->check(CLI::Range(std::int64_t{0}, std::numeric_limits<std::int64_t>::max()));
  add_path(*command, "--json", options->json_file, OutputKind::file, "write the figures as JSON");
  add_path(*command, "--report", options->report_file, OutputKind::file,
           "write an HTML report with curves and pictures");
  command->add_flag("--details", options->details, "print all tables, groups and conditions");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli::validate_command
