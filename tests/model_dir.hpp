// A model directory, as the tests read it.
#pragma once

#include <phynness/formats/model.hpp>

namespace phynness {

struct ModelDir {
  Model model;
  Mesh mesh;
};
inline ModelDir read_model_dir(const std::filesystem::path& dir) {
  const ModelTexts texts = read_model_texts(dir);
  ModelDir found{read_model_text(texts.model, (dir / "model.txt").string()),
                 read_mesh_text(texts.mesh, (dir / "mesh.txt").string())};
  require_mesh(found.mesh, found.model.mesh_hash);
  return found;
}

}  // namespace phynness
