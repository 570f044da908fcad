#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <phynness/formats/error.hpp>
#include <phynness/formats/model.hpp>
#include <random>

#include "../messages.hpp"
#include "../model_dir.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

struct ModelFolder {
  ModelFolder()
      : path(std::filesystem::temp_directory_path() / ("phynness_model_" + std::to_string(std::random_device{}()))) {
    mesh.nodes = Points::Random(20, 3);
    mesh.cells.resize(1, 4);
    mesh.cells << 0, 1, 2, 3;
    // Positive orientation, which mesh.txt demands.
    mesh.nodes.topRows(4) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    mesh.surface = boundary_triangles(mesh.cells);
    model = small_model();
    model.mesh_hash = mesh_hash(mesh);
  }
  ~ModelFolder() { std::filesystem::remove_all(path); }
  std::filesystem::path path;
  Mesh mesh;
  Model model;
};

// Claim: a model directory holds exactly its two files, also when it replaces an older one, and reads back equal.
TEST(ModelDirectory, HoldsExactlyTwoFiles) {
  ModelFolder folder;
  write_model_dir(folder.path, folder.model, folder.mesh);
  write_model_dir(folder.path, folder.model, folder.mesh);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names, (std::vector<std::string>{"mesh.txt", "model.txt"}));
  const ModelDir found = read_model_dir(folder.path);
  EXPECT_EQ(write_model_text(found.model), write_model_text(folder.model));
  EXPECT_EQ(read_model_texts(folder.path).model, write_model_text(folder.model));
  EXPECT_EQ(mesh_hash(found.mesh), folder.model.mesh_hash);
}

// Claim: a model never meets another mesh, neither on writing nor on reading; a missing file is named.
TEST(ModelDirectory, RefusesAnotherMesh) {
  ModelFolder folder, other;
  other.mesh.nodes(0, 0) -= 0.5;
  EXPECT_THROW(write_model_dir(folder.path, folder.model, other.mesh), Error);
  write_model_dir(folder.path, folder.model, folder.mesh);
  std::ofstream(folder.path / "mesh.txt", std::ios::binary) << write_mesh_text(other.mesh);
  expect_names(message_of([&] { read_model_dir(folder.path); }), {"mesh.txt"});
  std::filesystem::remove(folder.path / "mesh.txt");
  EXPECT_THROW(read_model_dir(folder.path), Error);
}

// Claim: the folder of a run, given instead of the model in it, is refused with the name of the model.
TEST(ModelDirectory, IsNamedInTheFolderOfARun) {
  ModelFolder folder;
  write_model_dir(folder.path / "model", folder.model, folder.mesh);
  expect_names(message_of([&] { read_model_dir(folder.path); }), {"give " + (folder.path / "model").string()});
}

}  // namespace
