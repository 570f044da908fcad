// What model.txt and mesh.txt will weigh.
#pragma once

#include <phynness/formats/database.hpp>
#include <phynness/formats/scene.hpp>

namespace phynness {

struct ModelSize {
  double model_text_bytes = 0, mesh_text_bytes = 0;
};

/// Writes a model of two active nodes with random numbers and continues the line. An upper bound where
/// networks may stop growing early ([training] target_mse).
/// @throws Error as write_model_text
ModelSize predict_model_size(const Scene& scene, const DatabaseHeader& header);

}  // namespace phynness
