// Stability of training: disturbed data and forced parameters, measured by the same new solves; and sources of the
// errors of trained models. Usage: tools/study-models SCENE database.h5 [--json FILE]
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/probe_solver.hpp>

#include "console.hpp"
#include "error_parts.hpp"
#include "exit_status.hpp"
#include "fixed_shapes.hpp"
#include "study_report.hpp"

namespace {

using namespace phynness;
using namespace phynness::study;
using nlohmann::json;

constexpr std::uint64_t noise_seed = 7;

struct Options {
  std::filesystem::path scene, database;
  std::optional<std::filesystem::path> json_file;
  std::int64_t probes = 1000, nodes = 10, seed = 1;
  int others = 60;
  std::vector<std::string> families{"modal", "rbfn"};
};

/// The solves with which every row is compared.
struct Fresh {
  std::vector<NodeProbes> all, calm;  ///< calm: at nodes that do not snap
};

/// The probes up to this depth only.
Fresh within(const Fresh& fresh, double depth_m) {
  Fresh some = fresh;
  for (auto* list : {&some.all, &some.calm})
    for (auto& node : *list) {
      node.states[1].clear();
      std::erase_if(node.states[0],
                    [&](const ProbedState& s) { return Eigen::Vector3d(s.d[0], s.d[1], s.d[2]).norm() > depth_m; });
    }
  return some;
}

bool all_finite(const LoadedModel& model, const std::vector<NodeProbes>& probes) {
  for (const auto& node : probes)
    for (const auto& group : node.states)
      for (const auto& state : group) {
        const auto said = model.respond({node.node}, {state.d});
        const auto& f = *said.force_N[0];
        if (!said.displacement_m.allFinite() || !std::isfinite(f[0] + f[1] + f[2])) return false;
      }
  return true;
}

void measure(Row& row, const LoadedModel& model, const Fresh& fresh) {
  // Nodes without a converged state have no model.
  Fresh known = fresh;
  for (auto* list : {&known.all, &known.calm})
    std::erase_if(*list, [&](const NodeProbes& p) {
      return std::none_of(model.model().nodes.begin(), model.model().nodes.end(),
                          [&](const auto& node) { return node.node == p.node; });
    });
  row.all = model_errors(model, known.all);
  row.calm = model_errors(model, known.calm);
  for (const auto& node : known.all) {
    const auto errors = model_errors(model, {node});
    row.by_node.push_back({errors.inside.force.mean, errors.inside.displacement.mean});
  }
  row.finite = all_finite(model, known.all);
}

class Study {
 public:
  Study(const Scene& scene, const StudyData& data, Fresh fresh)
      : _spec(scene.training), _data(data), _fresh(std::move(fresh)) {}

  void modal(const std::string& name, const StudyData& data, const ForcedShapes& forced = {}) {
    modal(name, data, _fresh, forced);
  }
  void modal(const std::string& name, const StudyData& data, const Fresh& fresh, const ForcedShapes& forced = {}) {
    row("modal", name, [&](Row& row) {
      const auto studied = train_modal(data, _spec, forced);
      const auto model = loaded(studied.model, data.header.mesh);
      measure(row, model, fresh);
      describe(row, data, studied);
    });
  }
  void rbfn(const std::string& name, const StudyData& data, double spread = 0) {
    row("rbfn", name, [&](Row& row) {
      TrainingSpec spec = _spec;
      if (spread > 0) spec.deformation_spread = spec.force_spread = spread;
      const auto model = loaded(train_rbfn(data, spec, row.diagonal_ratio), data.header.mesh);
      measure(row, model, _fresh);
    });
  }

  void modal_rows();
  void rbfn_rows();
  std::vector<ErrorParts> parts(const StudyData& data) const {
    const auto studied = train_modal(data, _spec, {});
    return error_parts(data, studied, loaded(studied.model, data.header.mesh), _fresh.all);
  }
  const std::vector<Row>& rows() const { return _rows; }

 private:
  void row(const char* family, const std::string& name, const std::function<void(Row&)>& work) {
    Row row;
    row.family = family;
    row.name = name;
    try {
      work(row);
    } catch (const Error& error) {
      const std::string text = error.what();
      row.refused = text.substr(0, text.find('\n'));
    }
    print_row(row);
    _rows.push_back(std::move(row));
  }

  static void describe(Row& row, const StudyData& data, const StudiedModal& studied) {
    const TrainingTables tables = training_tables(data.header);
    row.amplitude_shape = studied.model.shared.shape;
    row.smallest_shape = std::numeric_limits<double>::infinity();
    for (const auto& fit : studied.fits) {
      row.smallest_shape = std::min(row.smallest_shape, fit.force.network.shape);
      row.largest_shape = std::max(row.largest_shape, fit.force.network.shape);
      row.cancellation = std::max(row.cancellation, fit.force.cancellation);
      row.force_condition = std::max(row.force_condition, condition_number(fit.states, fit.force.network));
      row.amplitude_condition =
          std::max(row.amplitude_condition, condition_number(tables, studied.model.shared, fit.modes));
    }
    row.single = single_precision(studied.model, noise_seed);
  }

  TrainingSpec _spec;
  const StudyData& _data;
  Fresh _fresh;
  std::vector<Row> _rows;
};

/// Every second increment, including the deepest.
std::vector<std::size_t> every_second(std::size_t n) {
  std::vector<std::size_t> kept;
  for (std::size_t i = n % 2 == 0 ? 1 : 0; i < n; i += 2) kept.push_back(i);
  return kept;
}

/// Positions of the directions of a smaller set.
std::vector<std::size_t> found_among(const std::vector<Vec3>& directions, const std::vector<Vec3>& some) {
  std::vector<std::size_t> found;
  for (const auto& direction : some) {
    const auto at = std::find(directions.begin(), directions.end(), direction);
    if (at != directions.end()) found.push_back(static_cast<std::size_t>(at - directions.begin()));
  }
  return found;
}

void Study::modal_rows() {
  const std::size_t n_increments = _data.header.magnitudes_m.size();
  modal("as it is", _data);
  modal("every second increment", with_increments(_data, every_second(n_increments)));
  for (const auto kind : {Directions::fourteen, Directions::twenty_six}) {
    const auto fewer = exploratory_directions(kind);
    const auto found = found_among(_data.header.directions, fewer);
    if (found.size() == fewer.size() && found.size() < _data.header.directions.size())
      modal(fmt::format("{} of the directions", name(kind)), with_rays(_data, found));
  }
  modal("deepest increment alone", with_increments(_data, {n_increments - 1}));
  modal("10 % of the rays failed", with_failed_rays(_data, 0.1, noise_seed));
  modal("a third of the rays failed", with_failed_rays(_data, 1.0 / 3, noise_seed));
  modal("two thirds of the rays failed", with_failed_rays(_data, 2.0 / 3, noise_seed));
  modal("all rays failed but one", with_rays(_data, {0}));
  modal("all rays failed", with_rays(_data, {}));
  const auto half = failing_from(_data, n_increments / 2);
  const double half_m = _data.header.magnitudes_m[n_increments / 2 - 1];
  modal("rays end at half depth", half);
  modal("the same, probes to half depth", half, within(_fresh, half_m));
  modal("as it is, probes to half depth", _data, within(_fresh, half_m));
  modal("every probe twice", duplicated(_data, 0, noise_seed));
  modal("every probe twice, 1e-3 apart", duplicated(_data, 1e-3, noise_seed));
  for (const double level : {1e-4, 1e-3, 1e-2})
    modal(fmt::format("noise {:.0e}", level), with_noise(_data, level, noise_seed));
  for (const double shape : {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0})
    modal(fmt::format("force shape {:g}", shape), _data, {shape, 0});
  for (const double shape : {1e-3, 1e-2, 0.1, 1.0, 10.0, 100.0})
    modal(fmt::format("amplitude shape {:g}", shape), _data, {0, shape});
}

void Study::rbfn_rows() {
  rbfn("as it is", _data);
  rbfn("every second increment", with_increments(_data, every_second(_data.header.magnitudes_m.size())));
  rbfn("a third of the rays failed", with_failed_rays(_data, 1.0 / 3, noise_seed));
  rbfn("every probe twice", duplicated(_data, 0, noise_seed));
  rbfn("every probe twice, 1e-3 apart", duplicated(_data, 1e-3, noise_seed));
  for (const double level : {1e-3, 1e-2})
    rbfn(fmt::format("noise {:.0e}", level), with_noise(_data, level, noise_seed));
  for (const double spread : {0.05, 0.2, 0.5, 1.0, 2.0, 5.0, 20.0})
    rbfn(fmt::format("both spreads {:g}", spread), _data, spread);
}

/// Largest force of each active node over that of the median active node.
std::vector<double> force_ratios(const Database& database) {
  const auto n = static_cast<std::int32_t>(database.header().sets.active.size());
  cli::Progress progress("read", "nodes");
  std::vector<double> largest;
  for (std::int32_t i = 0; i < n; ++i) {
    largest.push_back(largest_force_N(database.rays(i)));
    progress.update(i + 1, n);
  }
  std::vector<double> sorted = largest;
  std::sort(sorted.begin(), sorted.end());
  for (double& f : largest) f /= sorted[sorted.size() / 2];
  return largest;
}

void add_options(CLI::App& app, Options& options) {
  app.add_option("SCENE", options.scene, "scene of the database")->required();
  app.add_option("DATABASE", options.database, "database.h5 of phynness precompute")->required();
  app.add_option("--probes", options.probes, "number of new solves, half of them inside the trained range")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--nodes", options.nodes, "number of active nodes that are trained and measured")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--seed", options.seed, "seed of the probes; nodes are those of phynness validate --nodes")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--others", options.others, "number of further nodes for the shared modes")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.add_option("--family", options.families, "families of the rows")->check(CLI::IsMember({"modal", "rbfn"}));
  app.add_option("--json", options.json_file, "write the results as JSON");
}

/// Nodes that snap, and the results of the new solves.
struct Solved {
  std::vector<double> ratios;  ///< force_ratios(), by active node
  Fresh fresh;
  std::vector<std::int32_t> probed;
  std::int64_t failed = 0;

  bool snaps(const std::vector<std::int32_t>& active, std::int32_t node) const {
    return ratios[static_cast<std::size_t>(std::lower_bound(active.begin(), active.end(), node) - active.begin())] >
           snap_ratio;
  }
};

Solved solve(const SolverSession& session, const Options& options, const Scene& scene, const Database& database,
             double tool_radius_m) {
  const auto skeleton = loaded(without_response(database, tool_radius_m), database.header().mesh);
  const auto plan = plan_probes(skeleton, scene.probe.directions, options.probes,
                                static_cast<std::uint64_t>(options.seed), options.nodes);
  Solved solved;
  solved.ratios = force_ratios(database);
  {
    cli::Progress progress("solve", "rays");
    solve_probes(
        session, scene, skeleton, plan, [&](std::int64_t done, std::int64_t total) { progress.update(done, total); },
        {}, [&](std::size_t, NodeProbes&& found) { solved.fresh.all.push_back(std::move(found)); });
  }
  for (const auto& node : solved.fresh.all) {
    if (!solved.snaps(database.header().sets.active, node.node)) solved.fresh.calm.push_back(node);
    solved.probed.push_back(node.node);
    solved.failed += node.failed;
  }
  return solved;
}

/// @return the errors of the linear predictor
json report_linear(const Fresh& fresh) {
  print_head();
  const auto linear = linear_errors(fresh.all), calm = linear_errors(fresh.calm);
  std::vector<std::array<double, 2>> by_node;
  for (const auto& node : fresh.all) {
    const auto errors = linear_errors({node});
    by_node.push_back({errors.inside.force.mean, errors.inside.displacement.mean});
  }
  print_errors("linear predictor", linear, calm, by_node);
  return {{"all", to_json(linear)}, {"without_snaps", to_json(calm)}};
}

/// @return the parts of the error of family modal
json report_parts(Study& study, const StudyData& data, const Solved& solved, const std::vector<std::int32_t>& active) {
  json out = json::object();
  const auto half = every_second(data.header.magnitudes_m.size());
  for (const auto& [name, some] :
       {std::pair{"as it is", data}, std::pair{"every second increment", with_increments(data, half)}}) {
    const auto parts = study.parts(some);
    std::vector<char> of_parts;
    for (const auto& p : parts) {
      of_parts.push_back(solved.snaps(active, p.node));
      out[name].push_back(to_json(p));
      out[name].back()["snaps"] = solved.snaps(active, p.node);
    }
    print_parts(name, parts, of_parts);
  }
  return out;
}

void write(const std::filesystem::path& file_name, const json& out) {
  std::ofstream file(file_name);
  file << out.dump(1) << '\n';
  if (!file.flush()) throw failure("writing failed", file_name.string(), "free space on the disk");
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app{"Stability of training and sources of its error (docs/stability.md)"};
  add_options(app, options);
  CLI11_PARSE(app, argc, argv);

  const SolverSession session;
  const Scene scene = read_scene(options.scene);
  const auto database = Database::open(options.database);
  if (physics_hash(scene) != database.header().physics_hash)
    throw input_error("the database belongs to another scene",
                      "physics " + database.header().physics_hash + ", this scene's " + physics_hash(scene),
                      "give the scene of the database (phynness info prints it)");
  const double tool_radius_m = scene.probe.kind == ProbeKind::patch ? scene.probe.tool_radius_m : 0;
  const auto solved = solve(session, options, scene, database, tool_radius_m);
  const auto& active = database.header().sets.active;
  const auto data = read_data(database, solved.probed, options.others, tool_radius_m);

  fmt::print("{}, {}, K/mu = {:.4g}, {} probes, R = {:.4g} mm, {} directions x {} increments\n", scene.title,
             name(scene.solver.element), scene.material.bulk_to_shear(), name(scene.probe.kind),
             1e3 * scene.probe.max_displacement_m, data.header.directions.size(), data.header.magnitudes_m.size());
  fmt::print(
      "{} probes at {} nodes, {} failed; of {} active nodes {} snap (largest force over {} times the "
      "median)\n\n",
      options.probes, solved.probed.size(), solved.failed, active.size(),
      std::count_if(solved.ratios.begin(), solved.ratios.end(), [](double r) { return r > snap_ratio; }), snap_ratio);
  json out{{"element", name(scene.solver.element)},
           {"bulk_to_shear", scene.material.bulk_to_shear()},
           {"probe", name(scene.probe.kind)},
           {"max_displacement_m", scene.probe.max_displacement_m},
           {"probes", options.probes},
           {"failed", solved.failed},
           {"seed", options.seed},
           {"nodes", solved.probed},
           {"snap_ratio", snap_ratio},
           {"linear", report_linear(solved.fresh)},
           {"rows", json::array()},
           {"parts", json::object()}};
  const auto wanted = [&](const char* family) {
    return std::find(options.families.begin(), options.families.end(), family) != options.families.end();
  };
  Study study(scene, data, solved.fresh);
  if (wanted("modal")) study.modal_rows();
  if (wanted("rbfn")) study.rbfn_rows();
  print_numbers(study.rows());
  if (wanted("modal")) out["parts"] = report_parts(study, data, solved, active);
  for (const auto& row : study.rows()) out["rows"].push_back(to_json(row));
  if (options.json_file) write(*options.json_file, out);
  return 0;
}

}  // namespace

int main(int argc, char** argv) { return phynness::bench::exit_status(run, argc, argv); }
