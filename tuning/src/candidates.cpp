#include <phynness/tuning/tuning.hpp>

#include "model_name.hpp"

namespace phynness {
namespace {

struct ModalSize {
  int modes, shared_modes, near_nodes, amplitude_centers, force_centers;
};

// From small to large: on the liver of docs/howto/own-organ.md memory and time of a deformation grow by
// factors of 1.1 to 1.7 from one to the next. Training takes no more force centers than half of a database's
// states, 78 with 26 directions in 6 increments; what is beyond is for more increments.
constexpr ModalSize modal_sizes[] = {{3, 12, 8, 20, 20},   {4, 24, 16, 26, 24},    {4, 40, 20, 30, 30},
                                     {6, 40, 20, 52, 40},  {8, 64, 24, 52, 60},    {12, 64, 24, 80, 80},
                                     {16, 64, 40, 80, 80}, {20, 96, 60, 104, 100}, {24, 120, 80, 156, 120}};

// The paper's sizes, and half and twice as many.
constexpr int neurons[] = {25, 50, 100, 200, 300, 400};

}  // namespace

std::vector<Candidate> tuning_candidates(const Scene& scene) {
  std::vector<Candidate> candidates;
  if (scene.material.law->linear) {
    TrainingSpec spec = scene.training;
    spec.family = Family::linear;
    candidates.push_back({model_name(spec), spec});
  }
  for (const auto& size : modal_sizes) {
    TrainingSpec spec = scene.training;
    spec.family = Family::modal;
    spec.modes = size.modes;
    spec.shared_modes = size.shared_modes;
    spec.near_nodes = size.near_nodes;
    spec.amplitude_centers = size.amplitude_centers;
    spec.force_centers = size.force_centers;
    candidates.push_back({model_name(spec), spec});
  }
  for (const int n : neurons) {
    TrainingSpec spec = scene.training;
    spec.family = Family::rbfn;
    spec.deformation_neurons = n;
    spec.force_neurons = std::min(n, 100);
    candidates.push_back({model_name(spec), spec});
  }
  return candidates;
}

}  // namespace phynness
