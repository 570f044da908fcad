// Database -> model: the paper's networks (section 2.2: scaling, orthogonal least squares, one spread);
// conservative forces and modes; or, for a linear body, three unit responses a node.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/training/conservative_fit.hpp>
#include <phynness/training/linear_fit.hpp>
#include <phynness/training/modal_fit.hpp>
#include <vector>

namespace phynness {

/// Means over the active nodes of a modal model; errors of each node over its largest force or displacement, equation
/// (17). What the exploratory directions do not tell (sampling) shows in the left-out errors; they are those of
/// interpolating all the others and so larger than what a model of all directions makes between them.
struct ModalQuality {
  struct OfField {
    double truncation = 0, regression = 0;
  };
  std::vector<OfField> fields;                    ///< one for each of Model::fields
  double force_training = 0, force_left_out = 0;  ///< regression alone; with a direction left out
  double truncation = 0;                          ///< of the modes, on the training states
  double regression = 0;                          ///< of the amplitudes, on the training states
  double amplitude_left_out = 0;                  ///< with a direction left out, of a sample of nodes
  double worst_cancellation = 0;                  ///< ConservativeFit::cancellation
  double smallest_force_shape = 0, largest_force_shape = 0, amplitude_shape = 0;
};

/// What belongs to the other families stays 0.
struct TrainingReport {
  std::int32_t n_networks = 0;                          ///< active nodes trained, of either family
  std::int32_t n_skipped = 0;                           ///< active nodes with no converged increment
  double deformation_spread = 0, force_spread = 0;      ///< used, in scaled inputs
  double mean_deformation_mse = 0, mean_force_mse = 0;  ///< of scaled outputs, on the training points
  double largest_diagonal_ratio = 1;  ///< worst NetworkFit::diagonal_ratio: how far weights may cancel
  LinearQuality linear;               ///< worst of all nodes
  ModalQuality modal;
  std::int64_t n_increments_used = 0;       ///< converged increments of the trained nodes
  std::int64_t n_increments_failed = 0;     ///< asked for and not converged, in all nodes: never trained on
  std::vector<std::int32_t> skipped_nodes;  ///< mesh node numbers behind n_skipped
  double seconds = 0;
};

/// Called as networks finish: (done, total). Return false to interrupt (an Error is thrown, nothing is
/// written).
using TrainingProgress = std::function<bool(std::int64_t, std::int64_t)>;

/// Where the responses come from: a database, or arrays made by a test or benchmark.
struct ResponseSource {
  const DatabaseHeader* header = nullptr;
  std::function<std::vector<Ray>(std::int32_t active)> rays;  ///< as Database::rays; called by one thread at a time
  double tool_radius_m = 0;                                   ///< of a patch probe; 0: node probe
  std::string title;
};

/// Family rbfn: trains a force and a deformation network for every active node with at least one converged
/// increment. Family linear: fits stiffness and unit responses instead (linear_fit.hpp); of `spec` only the
/// family counts. Family modal: fits a conservative force network and modes (conservative_fit.hpp, modal_fit.hpp). A
/// spread <= 0 is searched (spread_search.hpp), one value for all nodes. A network never has
/// more neurons than `largest_neuron_share` of its points.
/// @param spec      family, neurons, spreads [scaled inputs], samples, target MSE [scaled outputs], seed
/// @param report    filled when the call returns
/// @param progress  called by one thread at a time
/// @param threads   0: as many as there are cores; the result does not depend on it, bit for bit
/// @throws Error    input: a family not available, impossible numbers, no converged increment at all;
///                  a linear response asked of what is not linear; failure: interrupted, or the database
///                  holds values that are not finite
Model train(const ResponseSource& source, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress = {}, int threads = 0);

/// The same on a database; probe kind and title come from the scene that it holds.
/// @throws Error  also (input) on family linear where that scene's law is another
Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report,
            const TrainingProgress& progress = {}, int threads = 0);

}  // namespace phynness
