#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/locking.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/surface_points.hpp>
#include <phynness/validation/tool_pairs.hpp>
#include <phynness/validation/trained_share.hpp>
#include <phynness/validation/verdict.hpp>

#include "command_files.hpp"
#include "commands.hpp"
#include "console.hpp"
#include "error_json.hpp"
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
struct Compared {
  Scene scene;
  LoadedModel model;
};

Compared load(const Options& options, const SolverSession& session) {
  Scene scene;
  std::optional<LoadedModel> loaded;
  session.together([&] {
    scene = open_scene(options.scene);
    loaded.emplace(options.model);
    if (options.level) loaded->set_level(*options.level);
    if (session.rank() == 0) check_mesh(scene, loaded->model().mesh_hash, options.model.string());
  });
  return {std::move(scene), std::move(*loaded)};
}

/// @throws Error (input) if the model has forces only
void require_deformations(const Options& options, const LoadedModel& model) {
  if (!model.model().nodes.empty() &&
      model.respond({model.model().nodes.front().node}, {Vec3{}}).displacement_m.rows() == 0)
    throw input_error("coupled tools need deformations, but the model has forces only", options.model.string(),
                      "omit --points and --pairs, or train the model with modes");
}

struct Measured {
  ValidationReport report;
  PointReport points;
  PairReport pairs;
  std::optional<Error> no_points, no_pairs;  ///< why this part was not done
  std::uint64_t seed = 0;
  bool interrupted = false;
};

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

Measured measure(const Options& options, const SolverSession& session, const Compared& compared) {
  const auto& scene = compared.scene;
  const auto& model = compared.model;
  Measured m;
  m.seed = options.seed ? static_cast<std::uint64_t>(*options.seed) : scene.validation.seed;
  {
    Progress progress("validate", "rays");
    m.report = validate(
        session, scene, model, options.probes.value_or(scene.validation.probes), m.seed,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested, options.nodes);
  }
  m.interrupted = m.report.interrupted();
  if (options.points > 0 && !m.interrupted) {
    Progress progress("validate", "points");
    m.no_points = try_part([&] {
      require_deformations(options, model);
      m.points = validate_points(
          session, scene, model, options.points, displacements_per_point, m.seed,
          [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
      m.interrupted = m.points.interrupted();
    });
  }
  if (options.pairs > 0 && !m.interrupted) {
    Progress progress("validate", "pairs");
    m.no_pairs = try_part([&] {
      require_deformations(options, model);
      m.pairs = validate_pairs(
          session, scene, model, options.pairs,
          options.pair_depth_m.value_or(pair_depth_fraction * scene.probe.max_displacement_m), m.seed,
          [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
      m.interrupted = m.pairs.interrupted();
    });
  }
  return m;
}

std::vector<std::string> not_done(const Measured& m) {
  std::vector<std::string> parts;
  for (const auto& [part, reason] : {std::pair{"--points", &m.no_points}, std::pair{"--pairs", &m.no_pairs}})
    if (*reason) parts.push_back(fmt::format("{} was not done: {}", part, (*reason)->what()));
  return parts;
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

Validated validated(const Compared& c, const Measured& m) { return {c.scene, c.model, m.report, m.points, m.pairs}; }

void print(const Compared& compared, const Measured& m) {
  print_verdict(validated(compared, m));
  print_worse(worse_than_linear(validated(compared, m)));
  for (const auto& part : not_done(m)) print_result("{}\n", part);
  print_cells(summary_cells(validated(compared, m)));
}

void print_details(const Compared& compared, const Measured& m, int ranks) {
  const auto& report = m.report;
  const Model& model = compared.model.model();
  print_conditions(compared.scene, report);
  print_table(report, model.fields);
  print_to_range(report.to_range);
  print_result("{}\n", sentence(trained_share(model), model));
  print_summary(report);
  print_examples(report);
  if (m.points.finished > 0) print_points(m.points);
  if (m.pairs.finished > 0) print_pairs(m.pairs);
  print_result("runtime on this machine, one core: force {:.2f} us", report.speed.force_us);
  if (report.of(Predictor::model).inside.displacement.n > 0)
    print_result(", deformation of {} nodes {:.1f} us", model.output.size(), report.speed.deformation_us);
  if (!model.fields.empty()) print_result(", a field {:.1f} us", report.speed.field_us);
  print_result("\n");
  print_result("{} on {} rank{}\n", duration(report.seconds), ranks, ranks == 1 ? "" : "s");
}

json conditions(const Compared& compared, const Measured& m) {
  const Scene& scene = compared.scene;
  return {{"law", name(scene.material.law)},
          {"element", name(scene.solver.element)},
          {"bulk_to_shear", scene.material.bulk_to_shear()},
          {"probe", name(scene.probe.kind)},
          {"max_displacement_m", scene.probe.max_displacement_m},
          {"outside_factor", m.report.outside_factor},
          {"nodes", m.report.nodes},
          {"fixed_distances_m", m.report.fixed_distance_m},
          {"level", compared.model.data().level()},
          {"seed", m.seed}};
}

json as_json(const Compared& compared, const Measured& m) {
  const auto& report = m.report;
  const auto& fields = compared.model.model().fields;
  const auto& of_model = report.of(Predictor::model);
  const auto both = [&](const PredictorErrors& e) {
    return json{{"inside", to_json(e.inside, fields)}, {"outside", to_json(e.outside, fields)}};
  };
  json out{{"probes", report.probes},
           {"failed", report.failed},
           {"interrupted", m.interrupted},
           {"rays", report.rays},
           {"rays_finished", report.rays_finished},
           {"solved_inside", report.solved_inside},
           {"solved_outside", report.solved_outside},
           {"inside", to_json(of_model.inside, fields)},
           {"outside", to_json(of_model.outside, fields)},
           {"linear", both(report.of(Predictor::linear))},
           {"zero", both(report.of(Predictor::zero))},
           {"model_hash", compared.model.hash()},
           {"mesh_hash", compared.model.model().mesh_hash},
           {"conditions", conditions(compared, m)},
           {"distance_correlation",
            {{"inside", or_null(report.distance_correlation_inside)},
             {"outside", or_null(report.distance_correlation_outside)}}},
           {"examples", json::array()},
           {"force_us", report.speed.force_us},
           {"deformation_us", report.speed.deformation_us},
           {"field_us", report.speed.field_us},
           {"seconds", report.seconds},
           {"solve_ms_per_increment", report.solve_ms_per_increment}};
  for (const auto& line : verdict(validated(compared, m)))
    for (const auto& [key, value] : line.figures)
      out["verdict"][line.key][key] = std::isfinite(value) ? json(value) : json(nullptr);
  out["worse_than_linear"] = json::array();
  for (const auto& worse : worse_than_linear(validated(compared, m)))
    out["worse_than_linear"].push_back(
        {{"error", worse.what}, {"range", worse.range}, {"model", worse.model}, {"linear", worse.linear}});
  for (const auto& e : report.examples)
    out["examples"].push_back({{"node", e.node},
                               {"displacement", e.displacement_m},
                               {"force_finite_elements", e.finite_elements_N},
                               {"force_model", e.model_N},
                               {"force_linear", e.linear_N}});
  add_to_range(out, report.to_range, "nodes");
  out["beyond"] = to_json(report.to_range.beyond);
  out["unreached_beyond"] = report.to_range.unreached_beyond;
  out["by_node"] = by_node(report.to_range.nodes);
  if (m.points.finished > 0) out["points"] = to_json(m.points);
  if (m.pairs.finished > 0) out["pairs"] = to_json(m.pairs);
  if (m.no_points) out["points"] = {{"not_done", m.no_points->what()}};
  if (m.no_pairs) out["pairs"] = {{"not_done", m.no_pairs->what()}};
  return out;
}

/// @throws Error (failure)
void refuse_half(const Options& options, const Measured& m) {
  std::string finished = fmt::format("{} of {} rays", m.report.rays_finished, m.report.rays);
  if (options.points > 0) finished += fmt::format(", {} of {} points", m.points.finished, options.points);
  if (options.pairs > 0) finished += fmt::format(", {} of {} pairs", m.pairs.finished, options.pairs);
  throw failure("validate was interrupted; the figures above are those of the finished part", finished,
                fmt::format("run it again; --seed {} repeats the same probes{}", m.seed,
                            options.report_file ? "; the report was not written" : ""));
}

void write_report(const Options& options, const Compared& compared, const Measured& m) {
  write_text_file(*options.report_file, html_report({validated(compared, m), m.seed, software_version(), not_done(m)}));
  print_result("report: {}\n", options.report_file->string());
}

void run(const Options& options) {
  const SolverSession session;
  const Compared compared = load(options, session);
  install_stop_handler();
  const Measured measured = measure(options, session, compared);
  if (session.rank() != 0) return;
  print(compared, measured);
  if (options.details) print_details(compared, measured, session.size());
  write_each({[&] { write_json(options.json_file, as_json(compared, measured)); },
              [&] {
                if (options.report_file && !measured.interrupted) write_report(options, compared, measured);
              }});
  if (measured.interrupted) refuse_half(options, measured);
  const auto& reason = measured.no_points ? measured.no_points : measured.no_pairs;
  if (!reason) return;
  const char* parts = !measured.no_pairs    ? "--points was"
                      : !measured.no_points ? "--pairs was"
                                            : "--points and --pairs were";
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
