// Writes model directories for tests of devices: write_models DIR makes DIR/rbfn, DIR/linear and DIR/modal with 60
// neurons or centers of force and 26 directions, as in the paper; DIR/round has round tools and places between nodes,
// and relaxes; DIR/block has springs, and body.txt, a body of the same mesh, which relaxes.
#include <cmath>
#include <cstdio>
#include <exception>

#include <phynness/formats/scene.hpp>
#include <phynness/formats/text_file.hpp>

#include "../block_body.hpp"
#include "../model_dir.hpp"
#include "round_sample.hpp"

namespace phynness::test {
namespace {

Model model_of(Family family) {
  constexpr int n_force = 60;
  Model model = family == Family::linear  ? small_linear_model()
                : family == Family::modal ? small_modal_model(6, n_force, 12, 20)
                                          : small_model(40, n_force);
  const auto n_known = model.displacements.rows();
  model.directions.clear();
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const double size = std::sqrt(static_cast<double>(x * x + y * y + z * z));
        if (size > 0) model.directions.push_back({x / size, y / size, z / size});
      }
  const auto n_directions = static_cast<Eigen::Index>(model.directions.size());
  model.displacements.conservativeResize(2 * n_directions, 3);
  for (Eigen::Index i = n_known; i < 2 * n_directions; ++i)
    for (int k = 0; k < 3; ++k)
      model.displacements(i, k) =
          (i % 2 == 0 ? 0.005 : 0.01) * model.directions[static_cast<std::size_t>(i / 2)][static_cast<std::size_t>(k)];
  for (auto& node : model.nodes) node.trained_depth_m.assign(model.directions.size(), 0.01);
  return model;
}

Mesh mesh() {
  Numbers numbers;
  Mesh mesh;
  mesh.nodes.resize(20, 3);
  for (Eigen::Index i = 0; i < 20; ++i)
    for (int k = 0; k < 3; ++k) mesh.nodes(i, k) = numbers.next();
  mesh.nodes.topRows(4) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  mesh.cells.resize(1, 4);
  mesh.cells << 0, 1, 2, 3;
  mesh.surface = boundary_triangles(mesh.cells);
  return mesh;
}

}  // namespace
}  // namespace phynness::test

int main(int argc, char** argv) {
  using namespace phynness;
  if (argc != 2) {
    std::fputs("usage: write_models DIR\n", stderr);
    return 2;
  }
  try {
    const Mesh mesh = test::mesh();
    for (const Family family : {Family::rbfn, Family::linear, Family::modal}) {
      Model model = test::model_of(family);
      model.mesh_hash = mesh_hash(mesh);
      model.title = "comments: */ /* */ //*";
      model.solved = {true, "p1-p1", 500};
      model.finer = {true, "p1-p1", "half-size", 11, 0.03, 0.125, 0.25, 3000, 12};
      const auto dir = std::filesystem::path(argv[1]) / name(family);
      std::filesystem::create_directories(dir.parent_path());
      write_model_dir(dir, model, mesh);
    }
    const auto sample = read_model_dir(PHYNNESS_SOURCE_DIR "/examples/model");
    Relaxation relaxation;
    relaxation.terms.resize(2, 2);
    relaxation.terms << 0.3, 0.05, 0.2, 10;
    relaxation.length_m = 0.025;
    Model round = test::sample_of_round_tools(0.025);
    round.relaxation = relaxation;
    write_model_dir(std::filesystem::path(argv[1]) / "round", round, sample.mesh);
    test::Block block;
    block.body.relaxation = relaxation;
    block.body.mesh_hash = mesh_hash(block.mesh);
    block.body.coverage = 0.95;
    block.body.n_rays = 100;
    block.body.bounds = Eigen::MatrixXd::Constant(schema::n_coupled_kinds, schema::n_coupled_terms, 0.01);
    write_model_dir(std::filesystem::path(argv[1]) / "block", test::springs_on(block), block.mesh);
    write_text_file(std::filesystem::path(argv[1]) / "block/body.txt", write_body_text(block.body));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
