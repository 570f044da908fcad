// MODEL_DIR with model.txt and mesh.txt, which are replaced completely or not at all.
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <phynness/formats/model.hpp>
#include <phynness/formats/text_file.hpp>
#include <system_error>

namespace phynness {
namespace {

namespace fs = std::filesystem;

std::string read_file(const fs::path& file) {
  constexpr std::uint64_t most_bytes = std::uint64_t{16} << 30;
  return read_input_file(file, {"a file of the model directory",
                                "give a directory that `phynness train -o` has written", most_bytes, true});
}

}  // namespace

void write_model_dir(const fs::path& dir, const Model& model, const Mesh& mesh) {
  if (mesh_hash(mesh) != model.mesh_hash)
    throw failure("the model belongs to another mesh", model.mesh_hash, "write it with the mesh of its database");
  write_model_texts(dir, {write_model_text(model), write_mesh_text(mesh)});
}

void write_model_texts(const fs::path& dir, const ModelTexts& texts) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error)
    throw input_error("the directory cannot be made (" + error.message() + ")", dir.string(),
                      "give another directory with -o");
  // The model contains the hash of its mesh, so that a reader between the two renames gets an error instead of a
  // mixture.
  write_text_files({{dir / "mesh.txt", texts.mesh}, {dir / "model.txt", texts.model}});
}

ModelTexts read_model_texts(const fs::path& dir) {
  if (std::error_code code; fs::is_regular_file(dir, code))
    throw input_error("a file was given instead of a model directory", dir.string(),
                      "give a directory that `phynness train -o` has written; a body is given beside it, with --body");
  if (std::error_code code; !fs::exists(dir / "model.txt", code) && fs::exists(dir / "model/model.txt", code))
    throw input_error("this folder is no model directory, but it contains one", dir.string(),
                      "give " + (dir / "model").string());
  return {read_file(dir / "model.txt"), read_file(dir / "mesh.txt")};
}

void require_mesh(const Mesh& mesh, const std::string& hash) {
  if (mesh_hash(mesh) != hash)
    throw input_error("mesh.txt is not the mesh of model.txt", "hash " + mesh_hash(mesh) + " instead of " + hash,
                      "copy both files of one model directory");
}

}  // namespace phynness
