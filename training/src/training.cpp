#include <algorithm>
#include <chrono>
#include <mutex>
#include <phynness/formats/error.hpp>
#include <phynness/training/spread_search.hpp>
#include <phynness/training/training.hpp>
#include <string>
#include <thread>

#include "for_each_index.hpp"
#include "levels.hpp"

namespace phynness {
namespace {

/// Nodes that take part in a spread search, spread evenly over the list of active nodes.
constexpr std::int32_t n_search_nodes = 5;

/// Nodes whose modes the shared ones are made of; and the memory that they may take.
constexpr std::int32_t max_basis_nodes = 500, min_basis_nodes = 20;
constexpr double max_basis_bytes = 1e9;

/// Nodes whose amplitudes choose the centers.
constexpr std::int32_t n_center_nodes = 12;

/// Used where no node has enough points for a search.
constexpr double fallback_spread = 1.0;

/// Nodes whose deformation networks are asked for the errors of levels: what is left out are groups of
/// hundreds of points.
constexpr std::int32_t n_error_nodes = 20;

void check(const TrainingSpec& spec) {
  if (spec.levels < 1 || spec.levels > largest_level_count)
    throw input_error("levels must lie between 1 and " + std::to_string(largest_level_count),
                      std::to_string(spec.levels), "1 makes one network of the size asked for");
  if (spec.family == Family::modal) {
    if (spec.force_centers < 1 || spec.amplitude_centers < 0 || spec.modes < 0 || spec.shared_modes < 0 ||
        spec.near_nodes < 0 || spec.modes > largest_mode_count || spec.shared_modes > largest_mode_count) {
      throw input_error("impossible number of centers, modes or near nodes", "",
                        "force_centers is at least 1, modes and shared_modes at most " +
                            std::to_string(largest_mode_count) + ", none negative");
    }
    return;
  }
  if (spec.family == Family::linear) return;
  if (spec.samples < 1)
    throw input_error("samples must be at least 1", std::to_string(spec.samples), "the paper uses 5000");
  if (spec.deformation_neurons < 1 || spec.force_neurons < 1) {
    throw input_error("a network needs at least one neuron", "",
                      "the paper uses 200 for deformation and about 60 for force");
  }
  if (!(spec.target_mse >= 0))
    throw input_error("target_mse must not be negative", std::to_string(spec.target_mse), "use 0");
}

class Training {
 public:
  Training(const ResponseSource& source, const TrainingSpec& spec)
      : _source(source), _header(*source.header), _spec(spec), _tables(training_tables(_header)) {
    if (_spec.family == Family::linear) _spec.levels = 1;
  }

  SearchNode read(std::int64_t active_index) {
    const auto active = static_cast<std::int32_t>(active_index);
    const std::int32_t node = _header.sets.active[active];
    SearchNode read{node,
                    touched_nodes(_header.mesh.nodes, _header.mesh.surface, _header.sets.fixed, node,
                                  _source.tool_radius_m),
                    {}};
    // One read at a time: HDF5 need not be built thread-safe.
    const std::lock_guard lock(_source_mutex);
    read.rays = _source.rays(active);
    return read;
  }

  /// What all active nodes of a modal model share.
  void share(int threads) {
    if (_spec.family != Family::modal) return;
    _levels.resize(_spec.levels > 1 ? static_cast<std::size_t>(_spec.levels) : 0);
    if (_spec.modes == 0) {
      _shared.modes = scaled_table(Eigen::MatrixXd(3 * static_cast<Eigen::Index>(_tables.output.size()), 0));
      return;
    }
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    const auto components = static_cast<double>(3 + _header.fields.size());
    const double bytes_per_node = 8.0 * components * static_cast<double>(_tables.output.size()) * _spec.modes;
    const auto affordable =
        static_cast<std::int32_t>(std::min<double>(max_basis_nodes, max_basis_bytes / (bytes_per_node + 1)));
    const std::int32_t n = std::min(n_active, std::max(min_basis_nodes, affordable));
    std::vector<NodeModes> nodes(static_cast<std::size_t>(n));
    std::vector<std::vector<NodeModes>> of_field(_header.fields.size(), nodes);
    for_each_index(n, threads, [&](std::int32_t i) {
      const SearchNode read_node = read((2 * i + 1) * static_cast<std::int64_t>(n_active) / (2 * n));
      nodes[static_cast<std::size_t>(i)] =
          node_modes(_tables, read_node.prescribed, read_node.rays, _spec.modes);
      for (std::size_t f = 0; f < of_field.size(); ++f)
        of_field[f][static_cast<std::size_t>(i)] = field_modes(_tables, read_node.rays, f, 1, _spec.modes);
    });
    _shared.modes = scaled_table(shared_basis(nodes, _spec.shared_modes, _spec.seed));
    std::vector<NodeModes> some;
    const std::int32_t n_some = std::min(n, n_center_nodes);
    for (std::int32_t i = 0; i < n_some; ++i)
      some.push_back(std::move(nodes[static_cast<std::size_t>((2 * i + 1) * n / (2 * n_some))]));
    const auto chosen = choose_amplitude_centers(_tables, some, _spec.amplitude_centers);
    _shared.centers = chosen.row;
    _shared.shape = chosen.shape;
    _amplitude_left_out = chosen.left_out_error;
    const int n_centers = static_cast<int>(chosen.order.size());
    for (int l = 0; l < static_cast<int>(_levels.size()); ++l) {
      const int below = _spec.levels - 1 - l;
      _levels[static_cast<std::size_t>(l)] = {
          first_sorted(chosen.order, level_size(n_centers, below, least_amplitude_centers)),
          level_size(_spec.modes, below, least_modes)};
    }
    for (std::size_t f = 0; f < of_field.size(); ++f) share_field(_header.fields[f], of_field[f]);
  }

  void choose_spreads() {
    if (_spec.family != Family::rbfn) return;
    if (_spec.deformation_spread > 0 && _spec.force_spread > 0) return;
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    const std::int32_t n = std::min(n_active, n_search_nodes);
    std::vector<SearchNode> nodes;
    for (std::int32_t i = 0; i < n; ++i) nodes.push_back(read((2 * i + 1) * n_active / (2 * n)));
    if (!(_spec.force_spread > 0)) _spec.force_spread = search_force_spread(_tables, nodes, _spec);
    if (!(_spec.deformation_spread > 0))
      _spec.deformation_spread = search_deformation_spread(_tables, nodes, _spec);
    if (!(_spec.force_spread > 0)) _spec.force_spread = fallback_spread;
    if (!(_spec.deformation_spread > 0)) _spec.deformation_spread = fallback_spread;
  }

  Model run(TrainingReport& report, const TrainingProgress& progress, int threads) {
    const auto n_active = static_cast<std::int32_t>(_header.sets.active.size());
    std::vector<Outcome> outcomes(n_active);
    std::mutex progress_mutex;
    std::int64_t done = 0;
    for_each_index(n_active, threads, [&](std::int32_t active) {
      const SearchNode read_node = read(active);
      Outcome& outcome = outcomes[active];
      for (const Ray& ray : read_node.rays) {
        for (const Status status : ray.status) {
          outcome.used += status == Status::converged;
          outcome.failed += status != Status::converged && status != Status::not_requested;
        }
      }
      // Spread evenly over the active nodes.
      const std::int32_t stride = std::max(1, n_active / n_error_nodes);
      train_one(read_node, active % stride == stride / 2, outcome);
      const std::lock_guard lock(progress_mutex);
      if (progress && !progress(++done, n_active)) {
        throw failure("training was interrupted",
                      std::to_string(done) + " of " + std::to_string(n_active) + " nodes done",
                      "run the same command again; nothing was written");
      }
    });

    // Collected in the order of the nodes, so that sums and lists do not depend on who finished first.
    Model model = model_of_database(_header, _spec.family, _source.title);
    model.displacements = _tables.displacements;
    LevelErrors errors(_spec.levels);
    for (std::int32_t active = 0; active < n_active; ++active) {
      Outcome& outcome = outcomes[active];
      report.n_increments_used += outcome.used;
      report.n_increments_failed += outcome.failed;
      if (!outcome.trained) {
        report.skipped_nodes.push_back(_header.sets.active[active]);
        continue;
      }
      report.mean_force_mse += outcome.force_mse;
      report.mean_deformation_mse += outcome.deformation_mse;
      report.largest_diagonal_ratio = std::max(report.largest_diagonal_ratio, outcome.diagonal_ratio);
      keep_worst(report.linear, outcome.linear);
      add(report.modal, outcome);
      errors.add(outcome);
      model.nodes.push_back(std::move(outcome.model));
    }
    if (model.nodes.empty()) {
      throw input_error(
          "no active node has a converged increment", _header.scene_name,
          "look at the reasons with `phynness info`, then precompute with a smaller displacement");
    }
    report.n_networks = static_cast<std::int32_t>(model.nodes.size());
    report.n_skipped = static_cast<std::int32_t>(report.skipped_nodes.size());
    report.mean_force_mse /= report.n_networks;
    report.mean_deformation_mse /= report.n_networks;
    model.levels = errors.medians();
    for (std::size_t l = 0; l + 1 < _levels.size(); ++l) model.levels[l].centers = _levels[l].centers;
    if (_spec.family == Family::modal) {
      for (double* mean : {&report.modal.force_training, &report.modal.force_left_out,
                           &report.modal.truncation, &report.modal.regression})
        *mean /= report.n_networks;
      report.modal.amplitude_left_out = _amplitude_left_out;
      report.modal.amplitude_shape = _shared.shape;
      model.shared = _shared;
      for (std::size_t f = 0; f < _fields.size(); ++f) {
        for (auto* mean : {&report.modal.fields[f].truncation, &report.modal.fields[f].regression})
          *mean /= report.n_networks;
        model.fields.push_back(_fields[f]);
        model.fields.back().modes = _shared_of_field[f].modes;
      }
    }
    if (_spec.family == Family::rbfn) {
      report.force_spread = _spec.force_spread;
      report.deformation_spread = _spec.deformation_spread;
    }
    return model;
  }

 private:
  struct Outcome {
    bool trained = false;
    ActiveNodeModel model;
    double force_mse = 0, deformation_mse = 0, diagonal_ratio = 1;
    LinearQuality linear;
    ConservativeFit conservative;
    ModalFit modal;
    std::vector<ModalFit> fields;
    std::vector<double> force_errors, displacement_errors;  ///< by level; none: not estimated
    std::int64_t used = 0, failed = 0;
  };

  /// Medians over the nodes where errors were estimated: a node where the body snaps is told by no network,
  /// and would outweigh all others in a mean.
  class LevelErrors {
   public:
    explicit LevelErrors(int n_levels)
        : _force(n_levels > 1 ? static_cast<std::size_t>(n_levels) : 0), _displacement(_force.size()) {}
    void add(const Outcome& outcome) {
      for (std::size_t l = 0; l < outcome.force_errors.size(); ++l)
        _force[l].push_back(outcome.force_errors[l]);
      for (std::size_t l = 0; l < outcome.displacement_errors.size(); ++l)
        _displacement[l].push_back(outcome.displacement_errors[l]);
    }
    std::vector<ModelLevel> medians() const {
      std::vector<ModelLevel> levels;
      for (std::size_t l = 0; l < _force.size(); ++l)
        levels.push_back({median(_force[l]), median(_displacement[l]), {}});
      return levels;
    }

   private:
    static double median(std::vector<double> errors) {
      if (errors.empty()) return 0;
      std::sort(errors.begin(), errors.end());
      return errors[(errors.size() - 1) / 2];
    }

    std::vector<std::vector<double>> _force, _displacement;  ///< by level
  };

  void train_one(const SearchNode& read, bool estimate_errors, Outcome& outcome) const {
    const auto x = _header.mesh.nodes.row(read.node);
    const Vec3 point{x[0], x[1], x[2]};
    if (_spec.family == Family::linear) {
      LinearTraining training = train_linear_node(_tables, read.node, point, read.prescribed, read.rays);
      outcome.trained = training.trained;
      outcome.model = std::move(training.model);
      outcome.linear = training.quality;
      return;
    }
    if (_spec.family == Family::modal) return train_modal(read, point, outcome);
    NodeTraining training =
        train_node(_tables, read.node, point, read.prescribed, read.rays, _spec, estimate_errors);
    if (!training.trained) return;
    outcome.trained = true;
    outcome.force_mse = training.force.mse.back();
    outcome.deformation_mse = training.deformation.mse.back();
    outcome.diagonal_ratio = std::max(training.force.diagonal_ratio, training.deformation.diagonal_ratio);
    for (const auto& level : training.force.levels)
      if (estimate_errors) outcome.force_errors.push_back(level.left_out_error);
    for (const auto& level : training.deformation.levels)
      if (estimate_errors) outcome.displacement_errors.push_back(level.left_out_error);
    outcome.model = std::move(training.model);
  }

  void train_modal(const SearchNode& read, const Vec3& point, Outcome& outcome) const {
    const ForceStates forces = force_states(_tables, read.rays);
    if (forces.row.empty()) return;
    outcome.trained = true;
    outcome.conservative =
        fit_conservative(forces, _tables.magnitudes_m.back(), _spec.force_centers, _spec.levels);
    outcome.model = describe_node(_tables, read.node, point, read.prescribed, read.rays);
    outcome.model.conservative = std::move(outcome.conservative.network);
    auto& levels = outcome.model.levels;
    levels.resize(_levels.empty() ? 0 : _levels.size() - 1);
    for (auto& level : outcome.conservative.levels) outcome.force_errors.push_back(level.left_out_error);
    for (std::size_t l = 0; l < levels.size(); ++l)
      levels[l].conservative = std::move(outcome.conservative.levels[l].network);
    if (_spec.modes == 0) {
      outcome.model.modal.weights = scaled_table(Eigen::MatrixXd(3, 0));
      for (auto& level : levels) level.weights = outcome.model.modal.weights;
      return;
    }
    const NodeModes modes = node_modes(_tables, read.prescribed, read.rays, _spec.modes);
    outcome.modal = fit_modal(_tables, _shared, modes, _spec.near_nodes, 0, _levels);
    outcome.model.modal = std::move(outcome.modal.deformation);
    for (const auto& level : outcome.modal.levels)
      outcome.displacement_errors.push_back(level.left_out_error);
    for (std::size_t l = 0; l < levels.size(); ++l)
      levels[l].weights = std::move(outcome.modal.levels[l].weights);
    for (std::size_t f = 0; f < _fields.size(); ++f) {
      const auto& field = _fields[f];
      const NodeModes values = field_modes(_tables, read.rays, f, field.scale, _spec.modes);
      outcome.fields.push_back(
          fit_modal(_tables, _shared_of_field[f], values, _spec.near_nodes, field.degree, _levels));
      for (std::size_t l = 0; l < levels.size(); ++l)
        levels[l].field_weights.push_back(std::move(outcome.fields.back().levels[l].weights));
      outcome.model.fields.push_back(std::move(outcome.fields.back().deformation));
    }
  }

  /// Modes of a field that all nodes mix from; centers and kernel are those of the displacement.
  void share_field(Field field, const std::vector<NodeModes>& nodes) {
    FieldModes modes{name(field), unit(field), degree(field), 0, {}};
    for (const auto& node : nodes) modes.scale = std::max(modes.scale, node.largest);
    if (!(modes.scale > 0)) modes.scale = 1;
    _fields.push_back(std::move(modes));
    _shared_of_field.push_back(
        {scaled_table(shared_basis(nodes, _spec.shared_modes, _spec.seed)), _shared.centers, _shared.shape});
  }

  static void add(ModalQuality& sum, const Outcome& outcome) {
    sum.force_training += outcome.conservative.training_error;
    sum.force_left_out += outcome.conservative.left_out_error;
    sum.truncation += outcome.modal.truncation_error;
    sum.regression += outcome.modal.regression_error;
    sum.fields.resize(outcome.fields.size());
    for (std::size_t f = 0; f < outcome.fields.size(); ++f) {
      sum.fields[f].truncation += outcome.fields[f].truncation_error;
      sum.fields[f].regression += outcome.fields[f].regression_error;
    }
    sum.worst_cancellation = std::max(sum.worst_cancellation, outcome.conservative.cancellation);
    const double shape = outcome.model.conservative.shape;
    sum.largest_force_shape = std::max(sum.largest_force_shape, shape);
    if (sum.smallest_force_shape == 0 || shape < sum.smallest_force_shape) sum.smallest_force_shape = shape;
  }

  static void keep_worst(LinearQuality& worst, const LinearQuality& q) {
    worst.displacement_residual = std::max(worst.displacement_residual, q.displacement_residual);
    worst.force_residual = std::max(worst.force_residual, q.force_residual);
    worst.energy_residual = std::max(worst.energy_residual, q.energy_residual);
    worst.asymmetry = std::max(worst.asymmetry, q.asymmetry);
  }

  const ResponseSource& _source;
  const DatabaseHeader& _header;
  TrainingSpec _spec;
  TrainingTables _tables;
  SharedModes _shared;
  std::vector<FieldModes> _fields;  ///< their modes are in _shared_of_field
  std::vector<SharedModes> _shared_of_field;
  std::vector<AmplitudeLevel> _levels;  ///< modal; none if there is one
  double _amplitude_left_out = 0;
  std::mutex _source_mutex;
};

}  // namespace

Model train(const ResponseSource& source, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress, int threads) {
  const auto start = std::chrono::steady_clock::now();
  check(spec);
  if (threads <= 0) threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  report = {};
  Training training(source, spec);
  training.choose_spreads();
  training.share(threads);
  Model model = training.run(report, progress, threads);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

}  // namespace phynness
