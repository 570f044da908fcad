#include <fmt/core.h>

#include <functional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/text_file.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/report.hpp>
#include <phynness/validation/surface_points.hpp>

#include "commands.hpp"
#include "console.hpp"
#include "error_json.hpp"

namespace phynness::cli {
namespace {

/// (17) divides by the largest of a place's responses: one alone would be all there is to divide by.
constexpr std::int64_t displacements_per_point = 4;

struct Options {
  std::filesystem::path scene, model;
  std::optional<std::int64_t> probes;
  std::optional<std::int64_t> seed;
  std::int64_t nodes = 0, points = 0;
  std::optional<std::int32_t> level;
  std::optional<std::filesystem::path> json_file, report_file;
};

/// Two decimals, or the order of magnitude where those would show nothing.
std::string percent(double fraction) {
  const double value = 100 * fraction;
  return value > 0 && value < 0.005 ? fmt::format("{:7.0e}", value) : fmt::format("{:7.2f}", value);
}

void print_table(const ValidationReport& report, const std::vector<FieldModes>& fields) {
  using Member = std::function<const ErrorStatistics&(const GroupErrors&)>;
  const auto row = [&](const std::string& what, const Member& member, GroupErrors PredictorErrors::*group) {
    fmt::print("  {:<22}", what);
    for (const auto p : predictors) {
      const auto& s = member(report.of(p).*group);
      if (s.n == 0)
        fmt::print(" | {:>7} {:>7} {:>7}", "-", "-", "-");
      else
        fmt::print(" | {} {} {}", percent(s.mean), percent(s.p95), percent(s.max));
    }
    fmt::print("\n");
  };
  for (const auto& [title, group] : {std::pair{"inside the trained range", &PredictorErrors::inside},
                                     std::pair{"beyond it (to 1.43 times)", &PredictorErrors::outside}}) {
    fmt::print("{:<24} | {:^23} | {:^23} | {:^23}\n", title, "model", "linear predictor", "zero predictor");
    fmt::print("{:<24} | {:>7} {:>7} {:>7} | {:>7} {:>7} {:>7} | {:>7} {:>7} {:>7}\n", "  error in %", "mean",
               "p95", "max", "mean", "p95", "max", "mean", "p95", "max");
    row("force, eq. (17)", &GroupErrors::force, group);
    row("displacement, eq. (17)", &GroupErrors::displacement, group);
    row("  tenth moving most", &GroupErrors::displacement_moving, group);
    row("field, relative L2", &GroupErrors::field_l2, group);
    for (std::size_t f = 0; f < fields.size(); ++f) {
      row(
          fields[f].name + " (17)", [f](const GroupErrors& e) -> const auto& { return e.fields[f].nodal; },
          group);
      row(
          "  relative L2", [f](const GroupErrors& e) -> const auto& { return e.fields[f].l2; }, group);
    }
  }
}

void print_examples(const ValidationReport& report) {
  fmt::print("{:<8} {:>24} | {:>27} | {:>27}\n", "node", "displacement, mm", "force by finite elements, mN",
             "force by the model, mN");
  for (const auto& e : report.examples) {
    fmt::print("{:<8}", e.node);
    for (const double x : e.displacement_m) fmt::print(" {:8.2f}", 1e3 * x);
    fmt::print(" |");
    for (const double x : e.finite_elements_N) fmt::print(" {:8.2f}", 1e3 * x);
    fmt::print("  |");
    for (const double x : e.model_N) fmt::print(" {:8.2f}", 1e3 * x);
    fmt::print("\n");
  }
}

void print_points(const PointReport& report) {
  fmt::print("{} points of the surface, {} displacements each; {} not solved, {} unsettled by the model\n",
             report.points, report.displacements, report.failed, report.unsettled);
  fmt::print("{:<24} | {:^31} | {:^31} | {:^31}\n", "tools between nodes", "coupled model",
             "linear predictor", "model at the nearest nodes");
  fmt::print("{:<24}", "  error in %");
  for (int i = 0; i < 3; ++i) fmt::print(" | {:>7} {:>7} {:>7} {:>7}", "mean", "median", "p95", "max");
  fmt::print("\n");
  const auto row = [&](const char* what, const ErrorStatistics PointErrors::*member) {
    fmt::print("  {:<22}", what);
    for (const auto* errors : {&report.coupled, &report.linear, &report.at_nodes}) {
      const auto& s = errors->*member;
      fmt::print(" | {} {} {} {}", percent(s.mean), percent(s.median), percent(s.p95), percent(s.max));
    }
    fmt::print("\n");
  };
  row("force, as eq. (17)", &PointErrors::force);
  row("displacement", &PointErrors::displacement);
  row("field, relative L2", &PointErrors::field_l2);
  fmt::print("points follow their tools to {:.1e} m; {}\n", report.largest_residual_m,
             duration(report.seconds));
}

void run(const Options& options) {
  if (options.json_file)
    refuse_overwriting(*options.json_file,
                       {options.scene, options.model / "model.txt", options.model / "mesh.txt"});
  if (options.report_file) {
    refuse_overwriting(*options.report_file,
                       {options.scene, options.model / "model.txt", options.model / "mesh.txt"});
    if (options.json_file) refuse_overwriting(*options.report_file, {*options.json_file});
    const auto folder = std::filesystem::absolute(*options.report_file).parent_path();
    if (!std::filesystem::is_directory(folder) || std::filesystem::is_directory(*options.report_file))
      throw input_error("a report cannot be written there", options.report_file->string(),
                        "name a file in a folder that exists");
    require_plots();
  }
  install_stop_handler();
  const SolverSession session;
  Scene scene;
  std::optional<LoadedModel> loaded;
  session.together([&] {
    scene = read_scene(options.scene);
    loaded.emplace(options.model);
    if (options.level) loaded->set_level(*options.level);
    if (session.rank() == 0) check_mesh(scene, loaded->model().mesh_hash, options.model.string());
  });
  const LoadedModel& model = *loaded;
  if (options.points > 0 && !model.model().nodes.empty() &&
      model.respond({model.model().nodes.front().node}, {Vec3{}}).displacement_m.rows() == 0)
    throw input_error("tools between nodes need deformations, and the model has forces only",
                      options.model.string(), "leave --points out, or train with modes");
  const auto seed = options.seed ? static_cast<std::uint64_t>(*options.seed) : scene.validation.seed;
  ValidationReport report;
  {
    Progress progress("validate", "rays");
    report = validate(
        session, scene, model, options.probes.value_or(scene.validation.probes), seed,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested,
        options.nodes);
  }
  PointReport points;
  if (options.points > 0) {
    Progress progress("validate", "points");
    points = validate_points(
        session, scene, model, options.points, displacements_per_point, seed,
        [&](std::int64_t done, std::int64_t total) { progress.update(done, total); }, stop_requested);
  }
  if (session.rank() != 0) return;
  const double K_mu = scene.material.bulk_to_shear();
  std::string nodes;
  constexpr std::size_t most_named = 20;
  for (std::size_t i = 0; i < std::min(most_named, report.nodes.size()); ++i)
    nodes += (nodes.empty() ? "" : " ") + std::to_string(report.nodes[i]);
  if (report.nodes.size() > most_named) nodes += " ...";
  fmt::print("{} ({}), {}, K/mu = {:.4g}{}, {} probes, R = {:.4g} mm\n",
             scene.title.empty() ? "scene" : scene.title, name(scene.material.law),
             name(scene.solver.element), K_mu,
             scene.solver.element == Element::p1 && K_mu > 20 ? " (locked)" : "", name(scene.probe.kind),
             1e3 * scene.probe.max_displacement_m);
  fmt::print("{} probes at {} nodes ({} beside the fixed ones: {}); {} failed\n", report.probes,
             report.nodes.size(), report.n_beside_fixed, nodes, report.failed);
  const auto& fields = model.model().fields;
  print_table(report, fields);
  const auto& inside = report.of(Predictor::model).inside;
  if (inside.force.n > 0) fmt::print("median inside: force{} %", percent(inside.force.median));
  if (inside.displacement.n > 0) fmt::print(", displacement{} %", percent(inside.displacement.median));
  fmt::print("\n");
  fmt::print(
      "rank correlation of the force's error with the distance from what was trained: {:.2f} inside, {:.2f} "
      "beyond\n",
      report.distance_correlation_inside, report.distance_correlation_outside);
  print_examples(report);
  if (options.points > 0) print_points(points);
  fmt::print("runtime on this machine, one core: force {:.2f} us", report.speed.force_us);
  if (inside.displacement.n > 0)
    fmt::print(", deformation of {} nodes {:.1f} us", model.model().output.size(),
               report.speed.deformation_us);
  if (!fields.empty()) fmt::print(", a field {:.1f} us", report.speed.field_us);
  fmt::print("\n");
  fmt::print("{} on {} rank{}\n", duration(report.seconds), session.size(), session.size() == 1 ? "" : "s");
  const auto& of_model = report.of(Predictor::model);
  const auto both = [&](const PredictorErrors& e) {
    return json{{"inside", to_json(e.inside, fields)}, {"outside", to_json(e.outside, fields)}};
  };
  json out{
      {"probes", report.probes},
      {"failed", report.failed},
      {"solved_inside", report.solved_inside},
      {"solved_outside", report.solved_outside},
      {"inside", to_json(of_model.inside, fields)},
      {"outside", to_json(of_model.outside, fields)},
      {"linear", both(report.of(Predictor::linear))},
      {"zero", both(report.of(Predictor::zero))},
      {"conditions",
       {{"law", name(scene.material.law)},
        {"element", name(scene.solver.element)},
        {"bulk_to_shear", K_mu},
        {"probe", name(scene.probe.kind)},
        {"max_displacement_m", scene.probe.max_displacement_m},
        {"outside_factor", report.outside_factor},
        {"nodes", report.nodes},
        {"level", phn_level_of(model.data())},
        {"seed", seed}}},
      {"distance_correlation",
       {{"inside", report.distance_correlation_inside}, {"outside", report.distance_correlation_outside}}},
      {"examples", json::array()},
      {"force_us", report.speed.force_us},
      {"deformation_us", report.speed.deformation_us},
      {"field_us", report.speed.field_us},
      {"seconds", report.seconds},
      {"solve_ms_per_increment", report.solve_ms_per_increment}};
  for (const auto& e : report.examples)
    out["examples"].push_back({{"node", e.node},
                               {"displacement", e.displacement_m},
                               {"force_finite_elements", e.finite_elements_N},
                               {"force_model", e.model_N},
                               {"force_linear", e.linear_N}});
  if (options.points > 0) out["points"] = to_json(points);
  write_json(options.json_file, out);
  if (options.report_file) {
    write_text_file(*options.report_file, html_report({scene, model, report, seed, software_version()}));
    fmt::print("report: {}\n", options.report_file->string());
  }
}

}  // namespace

void add_validate_command(CLI::App& app) {
  auto options = std::make_shared<Options>();
  auto* command = app.add_subcommand("validate", "Compare a model with fresh finite element solves");
  command->add_option("SCENE", options->scene, "the scene the model was made from")->required();
  command->add_option("MODEL_DIR", options->model, "directory with model.txt and mesh.txt")->required();
  command->add_option("--probes", options->probes, "how many, inside and beyond the range together")
      ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--nodes", options->nodes,
                   "at how many active nodes (default: a twentieth of the probes, at least 10)")
      ->check(CLI::Range(1, 10'000'000));
  command
      ->add_option("--points", options->points,
                   "also tools at so many random points between nodes, against point-constrained solves")
      ->check(CLI::Range(1, 1'000'000));
  command->add_option("--level", options->level,
                      "level of the model, 0 the smallest (default: the full one)");
  command->add_option("--seed", options->seed, "of directions, magnitudes and nodes")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--json", options->json_file, "write the figures for machines");
  command->add_option("--report", options->report_file, "write a page for persons (.html; needs gnuplot)");
  command->callback([options] { run(*options); });
}

}  // namespace phynness::cli
