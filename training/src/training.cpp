// Trains all active nodes on several threads by the operations of a family (families.hpp), and computes the report.
#include <algorithm>
#include <chrono>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/training/training.hpp>
#include <string>

#include "family_training.hpp"
#include "linear_points.hpp"
#include "threads.hpp"

namespace phynness {
namespace {

/// Number of nodes whose errors of levels are estimated. The number is small because the groups of left-out points of
/// deformation networks have hundreds of points.
constexpr std::int32_t n_error_nodes = 20;

void check_spec(const TrainingSpec& spec) {
  if (spec.levels < 1 || spec.levels > largest_level_count)
    throw input_error("levels must be between 1 and " + std::to_string(largest_level_count),
                      std::to_string(spec.levels), "use 1 for a single network of the given size");
  operations(spec.family).check(spec);
}

/// Median over the nodes with estimated errors. It is used because a node where the body snaps through is not
/// represented by any network and would dominate a mean.
double median(const std::vector<NodeOutcome>& outcomes, std::vector<double> NodeOutcome::*of_levels,
              std::size_t level) {
  std::vector<double> errors;
  for (const auto& outcome : outcomes)
    if (level < (outcome.*of_levels).size()) errors.push_back((outcome.*of_levels)[level]);
  if (errors.empty()) return 0;
  std::sort(errors.begin(), errors.end());
  return errors[(errors.size() - 1) / 2];
}

class Training {
 public:
  Training(const ResponseSource& source, const TrainingSpec& spec)
      : _source(source), _header(*source.header), _tables(training_tables(_header)), _spec(spec) {
    if (!schema::traits(spec.family).has_levels) _spec.levels = 1;
    _training = operations(spec.family).training(_header, _tables, _spec);
  }

  Model run(TrainingReport& report, const OnProgress& progress, int threads) {
    _training->prepare([this](std::int64_t active) { return read(active); }, threads);
    return collect(train_nodes(progress, threads), report);
  }

 private:
  SearchNode read(std::int64_t active_index) {
    const auto active = static_cast<std::int32_t>(active_index);
    const std::int32_t node = _header.sets.active[active];
    SearchNode read{node, _header.sets.tools[active], {}};
    // Only one thread reads at a time, because HDF5 may not be thread-safe.
    const std::lock_guard lock(_source_mutex);
    read.rays = _source.rays(active);
    return read;
  }

  std::vector<NodeOutcome> train_nodes(const OnProgress& progress, int threads) {
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    std::vector<NodeOutcome> outcomes(n_active);
    std::mutex progress_mutex;
    std::int64_t done = 0;
    for_each_index(n_active, threads, [&](std::int32_t active) {
      const SearchNode read_node = read(active);
      NodeOutcome& outcome = outcomes[active];
      for (const Ray& ray : read_node.rays)
        for (const Status status : ray.status) {
          outcome.used += status == Status::converged;
          outcome.failed += static_cast<int>(status) < 0;
        }
      outcome.fitted = std::ssize(training_states(_tables, read_node.rays).row);
      // Errors are estimated at nodes that are distributed evenly over the active nodes.
      const std::int32_t stride = std::max(1, n_active / n_error_nodes);
      const auto x = _header.mesh.nodes.row(read_node.node);
      if (outcome.fitted > 0) _training->train(read_node, {x[0], x[1], x[2]}, active % stride == stride / 2, outcome);
      const std::lock_guard lock(progress_mutex);
      if (progress) progress(++done, n_active);
    });
    return outcomes;
  }

  /// Collects results in the order of the nodes, so that sums and lists do not depend on the order in which threads
  /// finish.
  Model collect(std::vector<NodeOutcome> outcomes, TrainingReport& report) const {
    Model model = model_of_database(_header, _spec.family, _source.title);
    model.displacements = _tables.displacements;
    for (std::size_t active = 0; active < outcomes.size(); ++active) {
      NodeOutcome& outcome = outcomes[active];
      report.n_increments_used += outcome.used;
      report.n_increments_failed += outcome.failed;
      report.n_increments_fitted += outcome.fitted;
      if (outcome.fitted == 0) {
        report.skipped_nodes.push_back(_header.sets.active[active]);
        continue;
      }
      _training->add(report, outcome);
      model.nodes.push_back(std::move(outcome.model));
    }
    if (model.nodes.empty())
      throw input_error("no active node has a converged increment", _header.scene_name,
                        "see the reasons with `phynness info`, and precompute with a smaller displacement");
    report.n_networks = static_cast<std::int32_t>(model.nodes.size());
    report.n_skipped = static_cast<std::int32_t>(report.skipped_nodes.size());
    for (std::size_t l = 0; _spec.levels > 1 && l < static_cast<std::size_t>(_spec.levels); ++l)
      model.levels.push_back({median(outcomes, &NodeOutcome::force_errors, l),
                              median(outcomes, &NodeOutcome::displacement_errors, l),
                              {}});
    _training->finish(model, report);
    if (_source.probe.kind != ProbeKind::patch) return model;
    if (!_header.sets.linear.empty()) add_linear_points(model, _header, _source.at_rest, _spec);
    cover_surface(model, _header.mesh, _source.probe.tool_radius_m, _source.spreads);
    return model;
  }

  const ResponseSource& _source;
  const DatabaseHeader& _header;
  TrainingTables _tables;
  TrainingSpec _spec;
  std::unique_ptr<FamilyTraining> _training;
  std::mutex _source_mutex;
};

}  // namespace

std::vector<TrainingSpec> candidates(const FamilyOperations& family, const TrainingSpec& given) {
  std::vector<TrainingSpec> all;
  for (const auto& numbers : family.candidates) {
    TrainingSpec& spec = all.emplace_back(given);
    spec.family = family.family;
    for (std::size_t i = 0; i < numbers.size(); ++i) spec.*family.sizes[i].second = numbers[i];
  }
  return all;
}

TrainingSpec sizes_of(const Model& model) {
  TrainingSpec spec;
  spec.family = model.family;
  spec.modes = spec.near_nodes = spec.force_centers = spec.deformation_neurons = spec.force_neurons = 0;
  spec.shared_modes = static_cast<int>(model.shared.modes.cols());
  spec.amplitude_centers = static_cast<int>(model.shared.centers.size());
  for (const auto& node : model.nodes) {
    spec.modes = std::max(spec.modes, static_cast<int>(node.modal.weights.cols()));
    spec.near_nodes = std::max(spec.near_nodes, static_cast<int>(node.modal.near.size()));
    spec.force_centers = std::max(spec.force_centers, static_cast<int>(node.conservative.centers.size()));
    spec.deformation_neurons = std::max(spec.deformation_neurons, static_cast<int>(node.deformation.weights.rows()));
    spec.force_neurons = std::max(spec.force_neurons, static_cast<int>(node.force.weights.rows()));
  }
  return spec;
}

const std::vector<const FamilyOperations*>& every_family() {
  static const std::vector<const FamilyOperations*> all = {&linear_operations, &modal_operations, &rbfn_operations};
  return all;
}

const FamilyOperations& operations(Family family) {
  const auto& all = every_family();
  return **std::find_if(all.begin(), all.end(), [&](const auto* each) { return each->family == family; });
}

Model train(const ResponseSource& source, const TrainingSpec& spec, TrainingReport& report, const OnProgress& progress,
            int threads) {
  const auto start = std::chrono::steady_clock::now();
  check_spec(spec);
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  report = {};
  Training training(source, spec);
  Model model = training.run(report, progress, threads);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

ResponseSource responses_of(const Database& database) {
  const Scene scene = stored_scene(database.header());
  ResponseSource source;
  source.header = &database.header();
  source.rays = [&database](std::int32_t active) { return database.rays(active); };
  source.at_rest = [&database](std::int32_t point) { return database.at_rest(point); };
  source.probe = scene.probe;
  source.spreads = spreads(scene.active);
  source.title = scene.title;
  return source;
}

Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report, const OnProgress& progress,
            int threads) {
  const Law law = stored_scene(database.header()).material.law;
  // Whether imported responses are linear, their numbers tell.
  if (schema::traits(spec.family).proportional && !law->linear && !database.header().imported)
    throw input_error("family linear needs the linear law", std::string("law ") + name(law),
                      "use family modal or rbfn");
  return train(responses_of(database), spec, report, progress, threads);
}

}  // namespace phynness
