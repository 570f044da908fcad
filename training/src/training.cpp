#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <phynness/formats/error.hpp>
#include <phynness/training/spread_search.hpp>
#include <phynness/training/training.hpp>
#include <string>
#include <thread>

namespace phynness {
namespace {

/// Nodes that take part in a spread search, spread evenly over the list of active nodes.
constexpr std::int32_t n_search_nodes = 5;

/// Used where no node has enough points for a search.
constexpr double fallback_spread = 1.0;

void check(const TrainingSpec& spec) {
  if (spec.family == Family::modal) {
    throw input_error("family comes with a later version", name(spec.family),
                      "use family rbfn, or linear where the law is");
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

/// Runs job(i) for i = 0 ... n - 1 on `threads` threads; the first exception stops all and is rethrown here.
template <class Job>
void for_each_index(std::int32_t n, int threads, const Job& job) {
  std::atomic<std::int32_t> next{0};
  std::atomic<bool> stop{false};
  std::exception_ptr problem;
  std::mutex problem_mutex;
  const auto work = [&] {
    for (std::int32_t i = next++; i < n && !stop; i = next++) {
      try {
        job(i);
      } catch (...) {
        const std::lock_guard lock(problem_mutex);
        if (!problem) problem = std::current_exception();
        stop = true;
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int t = 1; t < std::min(threads, n); ++t) helpers.emplace_back(work);
    work();
  }
  if (problem) std::rethrow_exception(problem);
}

class Training {
 public:
  Training(const ResponseSource& source, const TrainingSpec& spec)
      : _source(source), _header(*source.header), _spec(spec), _tables(training_tables(_header)) {}

  SearchNode read(std::int32_t active) {
    const std::int32_t node = _header.sets.active[active];
    SearchNode read{node, touched_nodes(_header.mesh.nodes, _header.mesh.surface, _header.sets.fixed, node, _source.tool_radius_m), {}};
    // One read at a time: HDF5 need not be built thread-safe.
    const std::lock_guard lock(_source_mutex);
    read.rays = _source.rays(active);
    return read;
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
      train_one(read_node, outcome);
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
    std::int64_t used = 0, failed = 0;
  };

  void train_one(const SearchNode& read, Outcome& outcome) const {
    const auto x = _header.mesh.nodes.row(read.node);
    const Vec3 point{x[0], x[1], x[2]};
    if (_spec.family == Family::linear) {
      LinearTraining training = train_linear_node(_tables, read.node, point, read.prescribed, read.rays);
      outcome.trained = training.trained;
      outcome.model = std::move(training.model);
      outcome.linear = training.quality;
      return;
    }
    NodeTraining training = train_node(_tables, read.node, point, read.prescribed, read.rays, _spec);
    if (!training.trained) return;
    outcome.trained = true;
    outcome.force_mse = training.force.mse.back();
    outcome.deformation_mse = training.deformation.mse.back();
    outcome.diagonal_ratio = std::max(training.force.diagonal_ratio, training.deformation.diagonal_ratio);
    outcome.model = std::move(training.model);
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
  Model model = training.run(report, progress, threads);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return model;
}

}  // namespace phynness
