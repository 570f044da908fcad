// Which model a scene needs: families and sizes trained on one database and measured on the same fresh
// solves.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/validation/validation.hpp>
#include <string>
#include <vector>

namespace phynness {

class SolverSession;

struct Candidate {
  std::string name;  ///< family and what its size is, in few words
  TrainingSpec spec;
};
/// Sizes of every family that the scene's law allows, each family from small to large. Spreads, samples and
/// seed are the scene's.
std::vector<Candidate> tuning_candidates(const Scene& scene);

/// What stands for the errors of many probes. The mean is made by few of them where the body snaps; the median
/// does not see these.
enum class ErrorStatistic { mean, median, p95 };

struct MeasuredModel {
  Candidate candidate;   ///< name: of the sizes that were made
  TrainingSpec trained;  ///< those: less than candidate.spec asks for where a database has few states
  PredictorErrors errors;
  RuntimeSpeed speed;
  double memory_bytes = 0, text_bytes = 0, training_s = 0;
  bool on_front = false;  ///< no other is at least as good in error, time and memory and better in one
  Model model;
  /// The larger of the errors (17) of force and displacement inside the trained range.
  /// Infinite if no probe was solved.
  double error(ErrorStatistic statistic) const;
};
void mark_front(std::vector<MeasuredModel>& models, ErrorStatistic statistic = ErrorStatistic::mean);

/// Largest allowed; absent: no limit.
struct TuningLimits {
  std::optional<double> error = {};           ///< of MeasuredModel::error(statistic), a fraction
  std::optional<double> deformation_us = {};  ///< one deformation of all output nodes
  std::optional<double> memory_bytes = {};    ///< of the model in the runtime
  ErrorStatistic statistic = ErrorStatistic::mean;
};

struct TuningChoice {
  std::optional<std::size_t> chosen;  ///< absent: none meets the limits
  std::string missed;                 ///< which limit none meets, and by how much; empty if there is a choice
};
/// With a limit of the error the fastest of those that meet all limits (the smaller of two as fast), without
/// one the most accurate. @pre models not empty
TuningChoice choose_model(const std::vector<MeasuredModel>& models, const TuningLimits& limits);

struct TuningReport {
  std::vector<MeasuredModel> models;
  std::vector<std::string> left_out;  ///< candidates that this database cannot train, and why
  PredictorErrors linear;             ///< the yardstick on the same solves
  std::int64_t probes = 0, failed = 0;
  std::vector<std::int32_t> nodes;  ///< probed
  double seconds = 0;
};

/// Called as work goes on: what is done, how far, of how many. Return false to interrupt (an Error is
/// thrown).
using TuningProgress = std::function<bool(const std::string&, std::int64_t, std::int64_t)>;

/// Trains each candidate on the whole database and measures it on `probes` fresh solves of random directions
/// and depths, half inside the trained range, at ten active nodes (validation.hpp says which), solved once.
/// Not collective: one process.
/// @throws Error if the database is not the scene's, or interrupted
TuningReport tune(const SolverSession& session, const Scene& scene, const Database& database,
                  const std::vector<Candidate>& candidates, std::int64_t probes, std::uint64_t seed,
                  const TuningProgress& progress = {});

}  // namespace phynness
