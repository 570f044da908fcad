// What a model of a size is called.
#pragma once

#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

inline std::string model_name(const TrainingSpec& spec) {
  const auto text = [](int n) { return std::to_string(n); };
  switch (spec.family) {
    case Family::modal:
      return "modal " + text(spec.modes) + " of " + text(spec.shared_modes) + " modes, " +
             text(spec.force_centers) + " centers";
    case Family::rbfn:
      return "rbfn " + text(spec.deformation_neurons) + " neurons, " + text(spec.force_neurons) +
             " for force";
    case Family::linear:
      break;
  }
  return "linear";
}

}  // namespace phynness
