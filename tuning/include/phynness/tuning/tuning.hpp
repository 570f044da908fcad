// Selection of a model for a scene: families and sizes are trained on one database and measured by the same new solves.
// And how far apart the points of a round tool may be: points of the database are left out, and their rays are the
// truth.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

namespace phynness {

class SolverSession;

struct Candidate {
  std::string name;  ///< short description of family and size
  TrainingSpec spec;
};
/// Sizes of all families that the scene's law allows, in ascending order for each family. Spreads, samples and seed are
/// those of the scene.
std::vector<Candidate> tuning_candidates(const Scene& scene);

/// Statistic of the errors of all probes. Where the body snaps through, a few probes dominate the mean, but do not
/// change the median.
enum class ErrorStatistic { mean, median, p95 };

struct MeasuredModel {
  Candidate candidate;   ///< its name describes the trained sizes
  TrainingSpec trained;  ///< trained sizes, which may be below candidate.spec if the database has few states
  PredictorErrors errors;
  RuntimeSpeed speed;
  double memory_bytes = 0, text_bytes = 0, training_s = 0;
  bool on_front =
      false;  ///< Pareto front: no other model is at least as good in error, time and memory and better in one
  Model model;
  /// The larger of the errors (17) of force and displacement inside the trained range.
  /// Infinite if no probe was solved.
  double error(ErrorStatistic statistic) const;
};
void mark_front(std::vector<MeasuredModel>& models, ErrorStatistic statistic = ErrorStatistic::mean);

/// Upper limits; empty: no limit.
struct TuningLimits {
  std::optional<double> error = {};           ///< of MeasuredModel::error(statistic), a fraction
  std::optional<double> deformation_us = {};  ///< time of one deformation of all output nodes
  std::optional<double> memory_bytes = {};    ///< memory of the model in the runtime
  ErrorStatistic statistic = ErrorStatistic::mean;
};

struct TuningChoice {
  std::optional<std::size_t> chosen;  ///< empty: no model meets the limits
  std::string missed;  ///< the limits that no model meets, with the smallest values; empty if one is chosen
};
/// Of the models that meet all limits: with a limit of the error the fastest (of equally fast models the smallest),
/// without it the most accurate. @pre models is not empty
TuningChoice choose_model(const std::vector<MeasuredModel>& models, const TuningLimits& limits);

struct TuningReport {
  std::vector<MeasuredModel> models;
  std::vector<std::string> left_out;  ///< candidates that cannot be trained on this database, with the reason
  PredictorErrors linear;             ///< errors of the linear predictor for the same solves, for comparison
  std::int64_t probes = 0, failed = 0;
  std::vector<std::int32_t> nodes;  ///< probed active nodes
  double seconds = 0;
};

/// Called with a description of the present work, the finished and the total number.
using TuningProgress = std::function<void(const std::string&, std::int64_t, std::int64_t)>;

/// Trains each candidate on the whole database and measures it by `probes` new solves with random directions and
/// depths, half of them inside the trained range, at ten active nodes (selected as in validation.hpp). The solves are
/// the same for all candidates. Must run as one process.
/// @throws Error (input) if the database belongs to another scene
TuningReport tune(const SolverSession& session, const Scene& scene, const Database& database, std::int64_t probes,
                  std::uint64_t seed, const TuningProgress& progress);

struct SpacingRow {
  double spacing_m = 0;
  std::int64_t points = 0;           ///< that the model has
  std::int64_t left_out = 0;         ///< nodes with rays, on which it is measured
  std::int64_t unanswered = 0;       ///< of these, nodes between whose neighbours the model does not answer
  ErrorStatistics between, nearest;  ///< forces of the model there; of the nearest point. Over the largest of the node
  PHYNNESS_FIGURES(spacing_m, points, left_out, unanswered, between, nearest)
};

/// Trains the scene's model on fewer and fewer points of the database, spread evenly, and compares its forces at all
/// states of the points that are left out. Nothing is solved. The spacings are a quarter to the whole of the tool's
/// radius, as far as they leave points out.
/// @throws Error (input) if the scene has no round tools or no point can be left out
std::vector<SpacingRow> compare_spacings(const Scene& scene, const std::filesystem::path& database,
                                         const TuningProgress& progress);

/// The largest spacing with an error of at most `error` and at most 5 % of the nodes unanswered; null: none.
const SpacingRow* sparsest(const std::vector<SpacingRow>& rows, double error, ErrorStatistic statistic);

}  // namespace phynness
