// Interface of the training of a family: first the part that all nodes share, then each node, then the report.
#pragma once

#include <functional>
#include <phynness/training/families.hpp>
#include <phynness/training/node_training.hpp>

namespace phynness {

extern const FamilyOperations rbfn_operations, linear_operations, modal_operations;

/// Reads the responses of an active node, given by its position in the list of active nodes. It is thread-safe.
using NodeReader = std::function<SearchNode(std::int64_t active)>;

/// Result of the training of one node.
struct NodeOutcome {
  ActiveNodeModel model;
  double force_mse = 0, deformation_mse = 0;
  LinearQuality linear;
  ConservativeFit conservative;
  ModalFit modal;
  std::vector<ModalFit> fields;
  std::vector<double> force_errors, displacement_errors;  ///< by level; empty: not estimated
  /// Numbers of increments: converged, failed, training states. Without training states the node is not trained.
  std::int64_t used = 0, failed = 0, fitted = 0;
};

class FamilyTraining {
 public:
  virtual ~FamilyTraining() = default;
  /// Computes the part that all nodes share; called before the first node.
  virtual void prepare(const NodeReader&, int /*threads*/) {}
  /// @pre an increment converged
  /// @param estimate_errors  estimate errors of levels, in families in which this is costly
  virtual void train(const SearchNode& read, const Vec3& point, bool estimate_errors, NodeOutcome& outcome) const = 0;
  /// Adds the figures of a node to the sums or extremes of the report; called in the order of the nodes.
  virtual void add(TrainingReport& report, const NodeOutcome& outcome) const = 0;
  /// Completes model and report after all nodes; family modal sets the centers of the amplitudes of each level.
  virtual void finish(Model& model, TrainingReport& report) const = 0;
};

template <class Training>
std::unique_ptr<FamilyTraining> make_training(const DatabaseHeader& header, const TrainingTables& tables,
                                              const TrainingSpec& spec) {
  return std::make_unique<Training>(header, tables, spec);
}

}  // namespace phynness
