// MODEL_DIR from texts that are known already.
#pragma once

#include <phynness/formats/model.hpp>

namespace phynness {

/// As write_model_dir(). @pre the mesh is that of the model
void write_model_texts(const std::filesystem::path& dir, const ModelTexts& texts);

}  // namespace phynness
