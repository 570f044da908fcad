// Training of one family: what its nodes share, then each node, then what the report says of all.
#pragma once

#include <functional>
#include <phynness/training/families.hpp>
#include <phynness/training/spread_search.hpp>

namespace phynness {

extern const FamilyOperations rbfn_operations, linear_operations, modal_operations;

/// Responses of the active node at a position in the list of active nodes. Any thread may call it.
using NodeReader = std::function<SearchNode(std::int64_t active)>;

/// What training of one node leaves.
struct NodeOutcome {
  bool trained = false;
  ActiveNodeModel model;
  double force_mse = 0, deformation_mse = 0, diagonal_ratio = 1;
  LinearQuality linear;
  ConservativeFit conservative;
  ModalFit modal;
  std::vector<ModalFit> fields;
  std::vector<double> force_errors, displacement_errors;  ///< by level; none: not estimated
  std::int64_t used = 0, failed = 0;                      ///< increments
};

class FamilyTraining {
 public:
  virtual ~FamilyTraining() = default;
  /// What all nodes share, before the first.
  virtual void prepare(const NodeReader&, int /*threads*/) {}
  /// @param estimate_errors  of levels, in families where that is costly
  virtual void train(const SearchNode& read, const Vec3& point, bool estimate_errors, NodeOutcome& outcome) const = 0;
  /// Adds a node's quality to the sums or extremes of the report; called in the order of the nodes.
  virtual void add(TrainingReport& report, const NodeOutcome& outcome) const = 0;
  /// Centers of the amplitudes of each level, where the family has such.
  virtual void finish(Model& model, TrainingReport& report) const = 0;
};

}  // namespace phynness
