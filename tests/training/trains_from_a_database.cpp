#include <gtest/gtest.h>

#include <Eigen/LU>
#include <filesystem>
#include <phynness/formats/error.hpp>
#include <random>

#include "../messages.hpp"
#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

std::string scene(const std::string& probe) {
  return "title = \"small\"\n[mesh]\nshape = \"block\"\n[material]\nlaw = \"neo-hookean\"\nc10_Pa = 250.0\n"
         "bulk_modulus_Pa = 1e4\n[nodes]\nfixed = { nodes = [1] }\n[probe]\nmax_displacement_m = "
         "0.012\nincrements = 4\n" +
         probe;
}

/// The small response set as a file that the test removes.
class FromDatabase : public testing::Test {
 protected:
  void write(const std::string& probe, const std::string& physics = "") {
    header.mesh.cells.resize(n_nodes / 4, 4);
    for (int i = 0; i < n_nodes; ++i) header.mesh.cells(i / 4, i % 4) = i;
    for (Eigen::Index c = 0; c < header.mesh.cells.rows(); ++c) {
      Eigen::Matrix3d edges;
      for (int k = 0; k < 3; ++k)
        edges.col(k) =
            header.mesh.nodes.row(header.mesh.cells(c, k + 1)) - header.mesh.nodes.row(header.mesh.cells(c, 0));
      if (edges.determinant() < 0) std::swap(header.mesh.cells(c, 2), header.mesh.cells(c, 3));
    }
    header.mesh.surface = boundary_triangles(header.mesh.cells);
    header.mesh_hash = mesh_hash(header.mesh);
    header.physics_hash = physics;
    header.float64 = true;
    header.sets.fixed = {1};
    header.sets.output.erase(header.sets.output.begin() + 1);
    header.scene_text = scene(probe);
    header.scene_name = "small.toml";
    header.scene_folder = std::string("/");
    DatabaseWriter::create(file, header, false);
    {
      DatabaseWriter writer(file, header, 0);
      for (std::int32_t active = 0; active < static_cast<std::int32_t>(header.sets.active.size()); ++active)
        for (const Ray& small : small_rays(header, active)) {
          Ray ray = empty_ray(header, active, small.direction);
          ray.status = small.status;
          ray.force = small.force;
          ray.displacement = small.displacement;
          writer.append(ray);
        }
    }
    DatabaseWriter::pack(file, header);
  }
  ~FromDatabase() override {
    std::filesystem::remove(file);
    std::filesystem::remove_all(file.string() + ".log");
  }

  std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("phynness_training_" + std::to_string(std::random_device{}()) + ".h5");
  DatabaseHeader header = small_header();
};

// Claim: what is trained from the file is what is trained from the same arrays, to the last bit, on two
// threads that share the file.
TEST_F(FromDatabase, EqualsTrainingFromArrays) {
  write("");
  const Database database = Database::open(file);
  TrainingReport report;
  const Model model = train(database, small_spec(), report, {}, 2);
  ResponseSource source = source_of(header);
  source.header = &database.header();
  EXPECT_EQ(write_model_text(model), write_model_text(train(source, small_spec(), report, {}, 1)));
  EXPECT_EQ(model.title, "small");
  EXPECT_EQ(model.mesh_hash, header.mesh_hash);
  for (const ActiveNodeModel& node : model.nodes) EXPECT_EQ(node.prescribed, std::vector<std::int32_t>{node.node});
}

// Claim: a model of round tools holds the nodes and weights that the database has of them.
TEST_F(FromDatabase, TheNodesOfAToolAreThoseOfTheDatabase) {
  for (auto& tool : header.sets.tools) {
    const auto node = tool.nodes.front();
    tool = {{0, node == 0 ? 2 : node}, {0.25, 0.75}, true};
  }
  write("kind = \"patch\"\ntool_radius_m = 0.025\n");
  const Database database = Database::open(file);
  TrainingReport report;
  const Model model = train(database, small_spec(), report);
  ASSERT_EQ(model.nodes.size(), header.sets.tools.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    EXPECT_TRUE(model.nodes[i].moves_mean);
    EXPECT_EQ(model.nodes[i].prescribed, header.sets.tools[i].nodes);
    EXPECT_EQ(model.nodes[i].prescribed_weight, header.sets.tools[i].weights);
  }
}

// Claim: the linear family is refused on a database of another law by that law's name, before any ray is read.
TEST_F(FromDatabase, LinearFamilyNeedsTheLinearLaw) {
  write("");
  const Database database = Database::open(file);
  TrainingReport report;
  TrainingSpec spec = small_spec();
  spec.family = Family::linear;
  expect_names(message_of([&] { train(database, spec, report); }), {"law neo-hookean"});
}

}  // namespace
