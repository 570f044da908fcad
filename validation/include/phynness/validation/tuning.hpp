// Selection of a model for a scene: families and sizes are trained on one database and measured by the same new solves.
#pragma once

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

struct MeasuredModel {
  Candidate candidate;  ///< the name contains the trained sizes
  PredictorErrors errors;
  RuntimeSpeed speed;
  double memory_bytes = 0, text_bytes = 0, training_s = 0;
  bool on_front =
      false;  ///< Pareto front: no other model is at least as good in error, time and memory and better in one
  Model model;
  /// The larger of the mean errors (17) of force and displacement inside the trained range. Infinite if no probe was
  /// solved.
  double error() const;
};
void mark_front(std::vector<MeasuredModel>& models);

/// Upper limits; an empty value is no limit.
struct TuningLimits {
  std::optional<double> error = {};           ///< limit of MeasuredModel::error()
  std::optional<double> deformation_us = {};  ///< time of one deformation of all output nodes
};

struct TuningChoice {
  std::optional<std::size_t> chosen;  ///< empty: no model meets the limits
  std::string missed;                 ///< the unmet limits with the smallest values; empty if a model is chosen
};
/// Of the models that meet both limits: with a limit of the error the fastest (of equally fast models the smallest),
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

/// Receives a description of the present work, and the finished and the total number of its parts.
using TuningProgress = std::function<void(const std::string&, std::int64_t, std::int64_t)>;

/// Trains each candidate on the whole database and measures it by `probes` new solves with random directions and
/// depths, half of them inside the trained range, at ten active nodes (selected as in validation.hpp). The solves are
/// the same for all candidates. Must run as one process.
/// @throws Error (input) if the database belongs to another scene
TuningReport tune(const SolverSession& session, const Scene& scene, const Database& database, std::int64_t probes,
                  std::uint64_t seed, const TuningProgress& progress);

}  // namespace phynness
