// Predicted sizes of model.txt and mesh.txt.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

struct ModelSize {
  double model_text_bytes = 0, mesh_text_bytes = 0;
};

/// Counts the bytes of a model of one and of two active nodes and extrapolates linearly. The result is an upper bound
/// if networks may stop growing early ([training] target_mse).
ModelSize predict_model_size(const Scene& scene, const DatabaseHeader& header);

}  // namespace phynness
