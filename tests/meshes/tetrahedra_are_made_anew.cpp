// Claims: `remesh = true` makes new tetrahedra within the surface of a file of tetrahedra, without its slivers, and
// says what changed; without a size the surface's triangles remain. What would be lost is refused. The worst cells are
// named with their place.
#include "../block_mesh.hpp"
#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

const auto slivers = std::filesystem::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes/broken/sliver_liver.vtk";

Scene remeshed(const std::filesystem::path& file, double scale_to_m, std::optional<double> edge_m) {
  Scene scene;
  scene.mesh.file = file;
  scene.mesh.scale_to_m = scale_to_m;
  scene.mesh.remesh = true;
  scene.mesh.target_size_m = edge_m;
  return scene;
}

TEST(NewTetrahedra, HaveNoSliversAndTheSameBody) {
  SKIP_WITHOUT_GMSH();
  const auto old = import_file(slivers, 0.001);
  ASSERT_GT(old.quality.n_slivers, 0);
  const auto result = make_mesh(remeshed(slivers, 0.001, 0.012));
  EXPECT_EQ(result.quality.n_slivers, 0) << result.quality.min_quality;
  // Edges cut off what is rounder than they are long: 12 mm on bends of some 30 mm.
  EXPECT_NEAR(result.quality.volume_m3, old.quality.volume_m3, 0.03 * old.quality.volume_m3);
  const auto notes = joined(result.notes);
  for (const std::string& part : {std::string("replaced 1575 cells (worst quality "),
                                  std::to_string(old.quality.n_slivers) + " below 0.1) of the file by " +
                                      std::to_string(result.quality.n_cells) + " cells (worst quality ",
                                  std::string("the volume changed by ")})
    EXPECT_TRUE(contains(notes, part)) << part << "\n" << notes;
  EXPECT_EQ(mesh_hash(make_mesh(remeshed(slivers, 0.001, 0.012)).mesh), mesh_hash(result.mesh));
}

TEST(NewTetrahedra, KeepTheTrianglesWithoutASize) {
  SKIP_WITHOUT_GMSH();
  const auto file = slivers.parent_path().parent_path() / "own/cylinder.msh";
  const auto old = import_file(file, 0.1);
  const auto filled = make_mesh(remeshed(file, 0.1, {}));
  EXPECT_EQ(filled.mesh.surface.rows(), old.mesh.surface.rows());
  EXPECT_NEAR(filled.quality.volume_m3, old.quality.volume_m3, 1e-9 * old.quality.volume_m3);  // rounding of sums
  EXPECT_NE(mesh_hash(filled.mesh), mesh_hash(old.mesh));
}

/// A block of 3 x 3 x 3 cubes without the middle one.
std::string hollow() {
  const Mesh block = block_mesh({3, 3, 3}, {0.03, 0.03, 0.03});
  std::string nodes, cells;
  int n = 0;
  for (int i = 0; i < block.n_nodes(); ++i)
    nodes += std::to_string(i + 1) + " " + std::to_string(block.nodes(i, 0)) + " " + std::to_string(block.nodes(i, 1)) +
             " " + std::to_string(block.nodes(i, 2)) + "\n";
  for (int c = 0; c < block.n_cells(); ++c) {
    const auto cell = block.cells.row(c);
    Eigen::RowVector3d center = Eigen::RowVector3d::Zero();
    for (const auto node : cell) center += block.nodes.row(node) / 4;
    if ((center.array() - 0.015).abs().maxCoeff() < 0.005) continue;
    cells += std::to_string(++n) + " 4 2 0 1";
    for (const auto node : cell) cells += " " + std::to_string(node + 1);
    cells += "\n";
  }
  return msh_2(cells, n, nodes, block.n_nodes());
}

TEST(NewTetrahedra, AreRefusedWhereTheFileWouldLoseSomething) {
  const TemporaryFile cavity(hollow(), ".msh");
  ASSERT_EQ(import_file(cavity.path).quality.n_cells, 156) << "the file itself is good";
  auto message = error_of([&] { make_mesh(remeshed(cavity.path, 1, 0.01)); });
  EXPECT_TRUE(contains(message, "cavities") && contains(message, "2 components")) << message;
  const auto surface = slivers.parent_path().parent_path() / "sofa_env/gallbladder_surface.stl";
  message = error_of([&] { make_mesh(remeshed(surface, 0.001, 0.01)); });
  EXPECT_TRUE(contains(message, "the file holds a surface") && contains(message, "remove mesh.remesh")) << message;

  const auto scene = [](const std::string& mesh, const std::string& nodes) {
    return "[mesh]\nfile = \"liver.msh\"\nremesh = true\n" + mesh +
           "\n[material]\nlaw = \"linear\"\nyoungs_modulus_Pa = 1e3\npoisson_ratio = 0.45\n[nodes]\n" + nodes +
           "\n[probe]\nmax_displacement_m = 0.01\n";
  };
  const auto refusal = [&](const std::string& mesh, const std::string& nodes) {
    return error_of([&] { parse_scene(scene(mesh, nodes), "body.toml", ".", MeshFile::may_be_absent); });
  };
  const std::string box = "fixed = { box = { min_fraction = [0, 0, 0], max_fraction = [0.2, 1, 1] } }";
  EXPECT_EQ(refusal("", box), "");
  for (const auto& [mesh, nodes, said] :
       {std::array<std::string, 3>{"", "fixed = { nodes = [1, 2, 3] }", "body.toml:10: [nodes] selects by nodes"},
        {"", "fixed = { group = \"hilum\" }", "body.toml:10: [nodes] selects by group"},
        {"", box + "\nactive = { difference = [\"free-surface\", { nodes = [5] }] }",
         "body.toml:11: [nodes] selects by"},
        {"thickness_m = 0.001", box, "[mesh] thickness_m cannot be combined with remesh"}})
    EXPECT_TRUE(contains(refusal(mesh, nodes), said)) << refusal(mesh, nodes);
}

TEST(WorstCells, AreNamedWithTheirPlace) {
  // The second of two tetrahedra on a common face is flat: its height over it is 0.01 of an edge.
  const auto made = import_bytes(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.34 0.34 0.34\n"), ".msh");
  const auto worst = worst_cells(made.mesh, {3, 4});
  ASSERT_EQ(worst.size(), 2u);
  EXPECT_EQ(worst[0].cell, 1);
  EXPECT_EQ(worst[0].quality, made.quality.min_quality);
  EXPECT_LT(worst[0].quality, worst[1].quality);
  EXPECT_EQ(worst[0].on_surface, 4);
  EXPECT_EQ(worst[0].fixed, 2);
  EXPECT_EQ(worst[1].fixed, 1);
  for (const double x : worst[0].center_m) EXPECT_NEAR(x, 0.335, 1e-15);
  EXPECT_EQ(worst_cells(made.mesh, {}, 1).size(), 1u);
  EXPECT_TRUE(contains(worst[0].str(), "cell 1: quality ") &&
              contains(worst[0].str(), ", at (335, 335, 335) mm, 4 of its 4 nodes on the surface, 2 fixed"))
      << worst[0].str();
}

}  // namespace
}  // namespace phynness::test
