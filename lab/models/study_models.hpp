// Models of the probed nodes only, made by the public functions of training.
#pragma once

#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/training/training.hpp>

#include "disturbed_data.hpp"

namespace phynness::study {

/// Forced shapes of the kernels; 0: chosen by training.
struct ForcedShapes {
  double force = 0, amplitude = 0;
};

/// Results of the fits of one node.
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

/// As train(), but with shared modes from the nodes of the data.
/// @param spec  sizes
StudiedModal train_modal(const StudyData& data, const TrainingSpec& spec, const ForcedShapes& forced);

/// @param spec  with both spreads > 0, or 0 to search
/// @param diagonal_ratio  output, the largest NetworkFit::diagonal_ratio
Model train_rbfn(const StudyData& data, TrainingSpec spec, double& diagonal_ratio);

/// All active nodes with their trained depths and without responses, for the selection of probes.
Model without_response(const Database& database, double tool_radius_m);

LoadedModel loaded(const Model& model, const Mesh& mesh);

}  // namespace phynness::study
