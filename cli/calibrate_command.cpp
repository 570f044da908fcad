#include <phynness/formats/body.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/validation/calibrate.hpp>
#include <phynness/validation/force_unit.hpp>
#include <phynness/validation/sizes.hpp>

#include "commands.hpp"

namespace phynness::cli::calibrate_command {
namespace {

/// The default for a finer reference: an increment of Taylor-Hood elements takes 20 times as long.
constexpr std::int64_t rays_of_finer = 100;

struct Options {
  std::filesystem::path model, database, output;
  OptionalPath json_file, scene, body;
  std::optional<std::int64_t> rays;
  std::int64_t seed = 1;
  std::string reference = "scene";
};

std::string promised_text(double share) {
  return fmt::format(", and in 19 of 20 calibrations at least {:.0f} % of fresh ones are", 100 * share);
}

void print_coupled(const BoundReport& report, const char* name, const CoupledCoverage& kind) {
  const auto flagged = fmt::format("{:.0f} % of the states drawn are flagged and have none", 100 * kind.flagged);
  if (kind.all.states > 0)
    print_result("{}: {} of rays left out are below their bound{}; {}\n", name, held_of_errors(kind.all),
                 promised_text(kind.promised), flagged);
  else if (report.planned_coupled_rays > 0)
    print_result("{}: no bound, because only {} of their rays were solved; {}\n", name, kind.rays, flagged);
}

void print(const BoundReport& report, const Model& model, const Options& options) {
  const auto& c = report.left_out;
  const ForceUnit unit = force_unit(report.median_bound_N);
  print_result(
      "median, over all solved states, of the bound of the force's error{}: {:.3g} {}, {:.3g} % of the force; {:.1f} % "
      "of the errors of {} left out of the calibration are below their bound{}\n",
      model.bounds.at(0).from(), unit.per_N * report.median_bound_N, unit.name, 100 * report.median_share, 100 * c.all,
      report.all_nodes ? "rays" : "nodes", promised_text(report.promised));
  print_result("{} random rays at {} nodes, {} states inside the trained range, {} rays ended early; {}\n", report.rays,
               report.nodes, report.states, report.failed_rays, duration(report.seconds));
  if (const auto failed = report.failed_rays + report.failed_coupled_rays;
      failed > 0 && report.reference != Variant::scene)
    message(
        "note: the finer solution ends early at {} of {} rays where the model's own finite elements go on; the bound "
        "says nothing of the displacements behind\n",
        failed, report.rays + report.coupled_rays);
  print_coupled(report, "one tool between nodes", report.coupled[0]);
  print_result("model with bounds -> {}\n", options.output.string());
}

json as_json(const BoundReport& report, double coverage) {
  json out = record("coverage", coverage);
  out.update(figures(report));
  return out;
}

/// Prints the predicted cost of a finer solution. @throws Error (input) if there is no such solution
void check_reference(const Database& database, const Scene& scene, const BoundSpec& spec,
                     const SolverSession& session) {
  if (spec.reference == Variant::scene) return;
  const auto cost = finer_cost(database, scene, spec, session.size());
  const auto memory = machine_memory_bytes();
  if (cost.memory_bytes > memory)
    throw input_error(
        "the finer solution does not fit into the memory of this machine",
        fmt::format("about {} on {} ranks, of {}", bytes(cost.memory_bytes), session.size(), bytes(memory)),
        session.size() > 1 ? "use fewer ranks, or a coarser mesh" : "use a coarser mesh");
  if (session.rank() == 0)
    message("note: {} rays of {} take about {} and {} of memory, by the times of the database\n", spec.rays,
            name(spec.reference), duration(cost.seconds), bytes(cost.memory_bytes));
}

void require_all(const BoundReport& report) {
  if (report.interrupted())
    throw failure("calibrate was interrupted; the bounds are those of the finished nodes, and hold, but are less exact",
                  fmt::format("{} of {} nodes, {} of {} rays of coupled tools", report.nodes, report.planned_nodes,
                              report.coupled_rays, report.planned_coupled_rays),
                  "run it again for all of them");
}

/// Calibrates the body instead of the model.
void run_for_body(const SolverSession& session, const Database& database, const NamedOrgan& model,
                  const BoundSpec& spec, const Options& options) {
  ReducedBody body;
  session.together([&] {
    body = read_body_text(read_body_file(*options.body), options.body->string());
    model.require_same("the body " + options.body->string(), body.mesh_hash, body.physics_hash);
    model.require_same("the database " + options.database.string(), database.header().mesh_hash,
                       database.header().physics_hash, "give the database of this model");
  });
  BoundReport report;
  calibrate(
      session, database, model, body, spec,
      [&](const std::string& text) {
        if (session.rank() == 0) message("note: {}\n", text);
      },
      Progress("calibrate", "rays").counter(), stop_requested, report);
  session.together([&] {
    if (session.rank() != 0) return;
    write_text_file(*options.body, write_body_text(body));
    print_coupled(report, "one tool", report.coupled[0]);
    print_coupled(report, "several tools", report.coupled[1]);
    print_result("body with bounds -> {}, in {}\n", options.body->string(), duration(report.seconds));
    write_json(options.json_file, as_json(report, body.coverage));
    require_all(report);
  });
}

void run(const Options& given_options) {
  Options options = given_options;
  if (options.body && (!options.output.empty() || options.reference != name(Variant::scene)))
    throw input_error(
        "--body excludes --output and --reference: the body is replaced, with the distance from its elements",
        options.body->string(), "omit them");
  if (options.body)
    check_place("--body", *options.body, PathKind::file);
  else if (options.output.empty())
    check_place("MODEL_DIR", options.output = options.model, PathKind::model);
  install_stop_handler();
  const SolverSession session;
  std::optional<NamedOrgan> model;
  std::optional<Database> database;
  session.together([&] {
    model.emplace(options.model);
    database.emplace(options.scene ? open_database(open_scene(*options.scene), options.database)
                                   : Database::open(options.database));
    if (!options.body && schema::traits(model->model().family).proportional)
      throw input_error("a linear model is exact and needs no bounds", options.model.string(),
                        "omit phynness calibrate");
  });
  BoundReport report;
  BoundSpec spec;
  session.together([&] {
    const auto scene = options.scene ? open_scene(*options.scene) : stored_scene(database->header());
    const auto named = variant_named(options.reference);
    spec.reference = named ? *named : finer_reference(scene);
    spec.rays = options.rays.value_or(spec.reference == Variant::scene
                                          ? sizes_of_checks(scene, database->header(), true).calibration_rays
                                          : rays_of_finer);
    check_reference(*database, scene, spec, session);
  });
  spec.seed = static_cast<std::uint64_t>(options.seed);
  if (options.body) return run_for_body(session, *database, *model, spec, options);
  const Model bounded =
      calibrate(session, *database, *model, spec, Progress("calibrate", "places").counter(), stop_requested, report);
  session.together([&] {
    if (session.rank() != 0) return;
    write_model_dir(options.output, bounded, model->mesh());
    print(report, bounded, options);
    write_json(options.json_file, as_json(report, bounded.bounds.at(0).coverage));
    require_all(report);
  });
}

}  // namespace

void add(CLI::App& app) {
  auto [command, options] =
      add_command(app, "calibrate", "Add bounds of the force's error to a model or a body: solves random rays", run);
  add_model(command, options.model);
  add_database(command, options.database, "database.h5 on which the model was trained");
  add_path(command, "-o,--output", options.output, PathKind::model,
           "model directory to write (default: MODEL_DIR, whose model.txt is replaced at the end)");
  add_path(command, "--body", options.body, PathKind::input,
           "a reduced body (body.txt) of the database, which gets bounds in place of the model, and is replaced at the "
           "end");
  add_path(command, "--scene", options.scene, PathKind::input,
           "scene with the keys of [validation], if not that of the database");
  add_count(command, "--rays", options.rays, 100, 1'000'000,
            "number of random rays, five at each node of a sample (default: validation.calibration_rays of the scene; "
            "100 with another --reference)");
  command
      .add_option("--reference", options.reference,
                  "the solution from which bounds state the distance of forces: the scene's own finite elements, or a "
                  "finer one; finer: taylor-hood, or half-size where the scene has none")
      ->check(CLI::IsMember({name(Variant::scene), "finer", name(Variant::taylor_hood), name(Variant::half_size)}))
      ->capture_default_str();
  add_count(command, "--seed", options.seed, 0, std::int64_t{1} << 53, "of the random numbers")->capture_default_str();
  add_json(command, options.json_file);
}

}  // namespace phynness::cli::calibrate_command
