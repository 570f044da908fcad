// MODEL_DIR with model.txt and mesh.txt, which are replaced completely or not at all.
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <sstream>
#include <system_error>

namespace phynness {
namespace {

namespace fs = std::filesystem;

std::string read_file(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    throw input_error("a file of the model directory cannot be read", file.string(),
                      "give a directory that `phynness train -o` has written");
  }
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throw failure("reading failed", file.string(), "check the disk");
  return std::move(text).str();
}

void write_file(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(text.data(), static_cast<std::streamsize>(text.size()));
  stream.close();
  if (!stream) {
    std::error_code ignored;
    fs::remove(file, ignored);
    throw failure("writing failed", file.string(), "check free space and permissions");
  }
}

void rename_over(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) throw failure("renaming failed (" + error.message() + ")", to.string(), "check permissions");
}

}  // namespace

void write_model_dir(const fs::path& dir, const Model& model, const Mesh& mesh) {
  if (mesh_hash(mesh) != model.mesh_hash) {
    throw failure("the model belongs to another mesh", model.mesh_hash, "write it with the mesh of its database");
  }
  const std::string model_text = write_model_text(model), mesh_text = write_mesh_text(mesh);
  std::error_code error;
  fs::create_directories(dir, error);
  if (error)
    throw input_error("the directory cannot be made (" + error.message() + ")", dir.string(),
                      "give another directory with -o");
  write_file(dir / "mesh.txt.part", mesh_text);
  write_file(dir / "model.txt.part", model_text);
  // The model contains the hash of its mesh, so that a reader between the two renames gets an error instead of a
  // mixture.
  rename_over(dir / "mesh.txt.part", dir / "mesh.txt");
  rename_over(dir / "model.txt.part", dir / "model.txt");
}

ModelTexts read_model_texts(const fs::path& dir) { return {read_file(dir / "model.txt"), read_file(dir / "mesh.txt")}; }

void require_mesh(const Mesh& mesh, const std::string& hash) {
  if (mesh_hash(mesh) != hash)
    throw input_error("mesh.txt is not the mesh of model.txt", "hash " + mesh_hash(mesh) + " instead of " + hash,
                      "copy both files of one model directory");
}

ModelDir read_model_dir(const fs::path& dir) {
  const ModelTexts texts = read_model_texts(dir);
  ModelDir found{read_model_text(texts.model, (dir / "model.txt").string()),
                 read_mesh_text(texts.mesh, (dir / "mesh.txt").string())};
  require_mesh(found.mesh, found.model.mesh_hash);
  return found;
}

}  // namespace phynness
