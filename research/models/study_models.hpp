// Models of the probed nodes alone, from the public pieces that training is made of.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/training/training.hpp>

#include "disturbed_data.hpp"

namespace phynness::study {

/// Shapes forced upon the kernels; 0: as training chooses.
struct ForcedShapes {
  double force = 0, amplitude = 0;
};

/// What training knows about the fits of one node.
struct NodeFit {
  ForceStates states;
  ConservativeFit force;
  NodeModes modes;
  ModalFit modal;
};

struct StudiedModal {
  Model model;
  std::vector<NodeFit> fits;  ///< one per node of the model
};

/// As train() does it, but for the nodes that the shared modes are made of: those of the data.
/// @param spec  sizes
StudiedModal train_modal(const StudyData& data, const TrainingSpec& spec, const ForcedShapes& forced);

/// @param spec  with both spreads > 0, or 0 to search
/// @param diagonal_ratio  set to the worst NetworkFit::diagonal_ratio
Model train_rbfn(const StudyData& data, TrainingSpec spec, double& diagonal_ratio);

/// All active nodes with their trained depths and no response: for the choice of probes.
Model without_response(const Database& database, double tool_radius_m);

LoadedModel loaded(const Model& model, const Mesh& mesh);

}  // namespace phynness::study
