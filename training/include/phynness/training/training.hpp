// Trains a model on a database: the paper's networks (section 2.2: scaling, orthogonal least squares, one spread);
// conservative forces and modes; or, for a linear body, three unit responses per node.
#pragma once

#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/progress.hpp>
#include <phynness/training/conservative_fit.hpp>
#include <phynness/training/linear_fit.hpp>
#include <phynness/training/modal_fit.hpp>
#include <vector>

namespace phynness {

/// Means over the active nodes of a modal model of errors (17), relative to the largest force or displacement of each
/// node. The left-out errors show the error between the exploratory directions. They are errors of an interpolation of
/// all other directions and therefore larger than the errors of a model of all directions.
struct ModalQuality {
  struct OfField {
    double truncation = 0, regression = 0;
  };
  std::vector<OfField> fields;                    ///< one for each of Model::fields
  double force_training = 0, force_left_out = 0;  ///< on the training states; with a direction left out
  double truncation = 0;                          ///< of the modes, on the training states
  double regression = 0;                          ///< of the amplitudes, on the training states
  double amplitude_left_out = 0;                  ///< with a direction left out, for a sample of nodes
};

/// Figures of other families remain 0.
struct TrainingReport {
  std::int32_t n_networks = 0;                          ///< trained active nodes of any family
  std::int32_t n_skipped = 0;                           ///< active nodes without a converged increment
  double deformation_spread = 0, force_spread = 0;      ///< used, in scaled inputs
  double mean_deformation_mse = 0, mean_force_mse = 0;  ///< of scaled outputs, on the training points
  LinearQuality linear;                                 ///< worst of all nodes
  ModalQuality modal;
  std::int64_t n_increments_used = 0;       ///< converged increments of the trained nodes
  std::int64_t n_increments_fitted = 0;     ///< of these, the training states (node_training.hpp)
  std::int64_t n_increments_failed = 0;     ///< requested increments of all nodes that did not converge
  std::vector<std::int32_t> skipped_nodes;  ///< mesh node numbers of the n_skipped nodes
  double seconds = 0;
};

/// Source of responses: a database, or arrays of a test or benchmark.
struct ResponseSource {
  const DatabaseHeader* header = nullptr;
  std::function<std::vector<Ray>(std::int32_t active)> rays;  ///< as Database::rays; never called concurrently
  ProbeSpec probe;                                            ///< kind and radius of the tool
  std::string title;
  bool spreads = false;  ///< the scene spreads the active nodes, between which round tools are answered
  std::function<AtRest(std::int32_t point)> at_rest = {};  ///< as Database::at_rest; unused without such points
};

/// The responses of a database, whose scene gives the kind of probe and the title. @pre the database outlives them
ResponseSource responses_of(const Database& database);

/// Trains every active node with at least one converged increment. Family rbfn: a force and a deformation network; a
/// spread <= 0 is searched (spread_search.hpp), with one value for all nodes, and `largest_neuron_share` limits the
/// number of neurons. Family linear: stiffness and unit responses (linear_fit.hpp); only the family of `spec` is used.
/// Family modal: a conservative force network and modes (conservative_fit.hpp, modal_fit.hpp).
/// @param spec      family, neurons, spreads [scaled inputs], samples, target MSE [scaled outputs], seed
/// @param report    output
/// @param progress  called with the numbers of finished and of all nodes, never concurrently; what it throws ends
/// training
/// @param threads   0: the number of cores; the result is bitwise independent of it
/// @throws Error (input) for impossible numbers, without any converged increment, or if family linear is used for
///   responses that are not linear; (failure) if the database has values that are not finite
Model train(const ResponseSource& source, const TrainingSpec& spec, TrainingReport& report,
            const OnProgress& progress = {}, int threads = 0);

/// Trains on a database, whose scene gives the kind of probe and the title.
/// @throws Error  as above; also (input) for family linear if the scene's law is not linear
Model train(const Database& database, const TrainingSpec& spec, TrainingReport& report, const OnProgress& progress = {},
            int threads = 0);

}  // namespace phynness
