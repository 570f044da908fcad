// Claims: cells with opposite numbering are flipped with a note. Flat, overlapping or separate cells, NaN coordinates
// and faces that do not match are refused with their numbers. Bodies that touch themselves are taken with a warning.
// Unreferenced nodes are dropped with a note, and the order of all others is kept.
#include "mesh_under_test.hpp"
#include "read/file_mesh.hpp"

namespace phynness::test {
namespace {

const char* flipped_cells = "1 4 2 0 1 1 3 2 4\n2 4 2 0 1 2 3 5 4\n";

TEST(Cells, AllNegativeAreFlippedWithANote) {
  const MeshResult good = import_bytes(msh_2(two_cells, 2), ".msh");
  const MeshResult flipped = import_bytes(msh_2(flipped_cells, 2), ".msh");
  EXPECT_TRUE(contains(joined(flipped.notes), "flipped all 2 cells")) << joined(flipped.notes);
  EXPECT_TRUE(good.notes.empty());
  EXPECT_DOUBLE_EQ(flipped.quality.volume_m3, good.quality.volume_m3);
}

TEST(Cells, SomeNegativeAreFlippedOneByOneWithANote) {
  const MeshResult result = import_bytes(msh_2("1 4 2 0 1 1 2 3 4\n2 4 2 0 1 2 3 5 4\n", 2), ".msh");
  EXPECT_TRUE(contains(joined(result.notes), "flipped 1 cell of 2")) << joined(result.notes);
  EXPECT_NEAR(result.quality.volume_m3, 0.5, 1e-15);
}

TEST(Cells, OverlappingNeighboursAreInverted) {
  // Node 5 lies on the same side of the common face as node 1.
  expect_names(import_error(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.1 0.1 0.1\n"), ".msh"),
               {"inverted", "2 cells: 0, 1"});
}

TEST(Cells, WithoutVolumeAreRefusedWithTheirNodes) {
  const std::string message =
      import_error(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 1 1 1\n"), ".msh");
  EXPECT_TRUE(contains(message, "cell 0 has no volume") && contains(message, "nodes 0 1 2 3")) << message;
}

TEST(Cells, WithNanCoordinatesAreRefused) {
  const std::string message =
      import_error(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 nan 1\n"), ".msh");
  EXPECT_TRUE(contains(message, "cell 1") && contains(message, "not finite") && contains(message, "node 4")) << message;
}

const char* twin_nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n6 1 0 0\n7 0 1 0\n8 0 0 1\n";
const char* unmerged_cells = "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 6 5 7 8\n";

TEST(Cells, NodesAtTheSamePlaceAreMergedWithANote) {
  const MeshResult result = import_bytes(msh_2(unmerged_cells, 2, twin_nodes, 8), ".msh");
  EXPECT_EQ(result.mesh.n_nodes(), 5);
  EXPECT_TRUE(contains(joined(result.notes), "merged 3 nodes")) << joined(result.notes);
}

TEST(Cells, SeparatePiecesAreRefusedOrTheLargestIsKept) {
  const std::string nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n6 5 0 0\n7 6 0 0\n8 5 1 0\n9 5 0 1\n";
  const std::string cells = std::string(two_cells) + "3 4 2 0 1 6 7 8 9\n";
  expect_names(import_error(msh_2(cells, 3, nodes, 9), ".msh"), {"2 components of 2 and 1 cells"});
  const MeshResult result = import_bytes(msh_2(cells, 3, nodes, 9), ".msh", true);
  EXPECT_EQ(result.mesh.n_cells(), 2);
  EXPECT_TRUE(
      contains(joined(result.notes), "kept the largest of 2 components of 2 and 1 cells, 0.5 m^3; dropped 0.167"))
      << joined(result.notes);
}

// One would turn about the other: no finite elements hold it.
TEST(Cells, TouchingAlongAnEdgeOnlyAreTwoPieces) {
  const std::string nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 -1 0\n6 0 0 -1\n";
  const std::string cells = "1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 5 6\n";
  expect_names(import_error(msh_2(cells, 2, nodes, 6), ".msh"), {"2 components", "nodes 0, 1"});
  EXPECT_EQ(import_bytes(msh_2(cells, 2, nodes, 6), ".msh", true).mesh.n_cells(), 1);
}

/// Cubes at integer places, divided from the corner of the smallest number.
meshes::RawMesh cubes(const std::vector<std::array<int, 3>>& places) {
  meshes::RawMesh raw;
  for (const auto& [i, j, k] : places) {
    std::vector<std::int32_t> corners;
    for (const auto& [a, b, c] :
         {std::array{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}) {
      corners.push_back(static_cast<std::int32_t>(raw.nodes.size()));
      raw.nodes.push_back({1.0 * i + a, 1.0 * j + b, 1.0 * k + c});
    }
    raw.add_cell(corners);
  }
  raw.finish(false);
  raw.file_number.clear();
  return raw;
}

using Places = std::vector<std::array<int, 3>>;
const Places arch = {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {2, 0, 1}, {2, 1, 1}};

TEST(Bodies, ThatTouchThemselvesAreTakenWithAWarning) {
  Places node = arch, edge = arch;
  edge.push_back({1, 1, 1}), edge.push_back({1, 1, 0});  // beside the first cube along an edge
  node.push_back({2, 1, 0}), node.push_back({2, 1, -1}), node.push_back({1, 1, -1});  // at a corner of it
  const Places corner = {{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {1, 0, 1}, {0, 0, 1}};
  const std::pair<Places, const char*> bodies[] = {{edge, "non-manifold edge"}, {node, "pinched vert"}};
  for (const auto& [places, defect] : bodies) {
    const MeshResult result = meshes::checked_body(cubes(places), 1, false, "f");
    EXPECT_NEAR(result.quality.volume_m3, static_cast<double>(places.size()), 1e-12);
    EXPECT_TRUE(contains(joined(result.warnings), "touches itself") && contains(joined(result.warnings), defect))
        << joined(result.warnings);
  }
  EXPECT_FALSE(contains(joined(meshes::checked_body(cubes(corner), 1, false, "f").warnings), "touches"));
}

TEST(Bodies, WhosePiecesShareNodesThatAreNotOnALineAreOnePiece) {
  const MeshResult result = meshes::checked_body(cubes({{0, 0, 0}, {0, 0, -1}, {1, 0, -1}, {1, 1, 0}}), 1, false, "f");
  EXPECT_EQ(result.mesh.n_cells(), 24);
  EXPECT_TRUE(contains(joined(result.warnings), "touches itself")) << joined(result.warnings);
  EXPECT_TRUE(contains(error_of([] {
                         meshes::checked_body(cubes({{0, 0, 0}, {1, 1, 1}}), 1, false, "f");
                       }),
                       "turn about"));
}

TEST(Bodies, WhoseCellsAreDividedAlongCrossingDiagonalsAreRefusedForThat) {
  for (const bool crossing : {false, true}) {
    meshes::RawMesh raw = cubes({{0, 0, 0}}), other = cubes({{0, 0, 0}});
    for (auto& x : other.nodes) x = {x[0] + 1, crossing ? 1 - x[1] : x[1], x[2]};
    for (auto cell : other.tetrahedra) {
      for (auto& node : cell) node += 8;
      raw.tetrahedra.push_back(cell);
    }
    raw.nodes.insert(raw.nodes.end(), other.nodes.begin(), other.nodes.end());
    raw.finish(true);
    const std::string message =
        error_of([&] { EXPECT_EQ(meshes::checked_body(raw, 1, false, "f").mesh.n_nodes(), 12); });
    EXPECT_EQ(contains(message, "split along different diagonals: 1 place, first nodes 1 2 5 6"), crossing) << message;
    EXPECT_EQ(message.empty(), !crossing);
  }
}

// A gap of rounding errors is closed on request, and told without.
TEST(Bodies, WhoseHalvesAreApartByRoundingErrorsAreMergedOnRequest) {
  meshes::RawMesh raw = cubes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  const auto half = [&](double gap) {
    meshes::RawMesh apart = raw;
    const auto n = static_cast<std::int32_t>(raw.nodes.size());
    for (const auto& x : raw.nodes) apart.nodes.push_back({x[0] + gap, x[1], x[2]});
    for (std::size_t c = 12; c < 18; ++c)
      for (auto& node : apart.tetrahedra[c]) node += n;
    return apart;
  };
  expect_names(error_of([&] { meshes::checked_body(half(1e-7), 1, false, "f"); }),
               {"4 nodes are within 1e-07 m", "mesh.repair"});
  const MeshResult merged = meshes::checked_body(half(1e-7), 1, true, "f");
  EXPECT_EQ(merged.mesh.n_nodes(), 16);
  EXPECT_TRUE(contains(joined(merged.notes), "repair: merged nodes nearer than a hundredth")) << joined(merged.notes);
  EXPECT_FALSE(contains(error_of([&] { meshes::checked_body(half(0.1), 1, false, "f"); }), "within"));
  EXPECT_EQ(meshes::checked_body(half(0.1), 1, true, "f").mesh.n_cells(), 12);
}

TEST(Nodes, UnreferencedAreDroppedByNameAndTheRestKeepTheirOrder) {
  const std::string nodes = "9 7 7 7\n1 0 0 0\n4 0 0 1\n3 0 1 0\n8 6 6 6\n2 1 0 0\n5 1 1 1\n";
  const MeshResult result = import_bytes(msh_2(two_cells, 2, nodes, 7), ".msh");
  ASSERT_EQ(result.mesh.n_nodes(), 5);
  EXPECT_TRUE(contains(joined(result.notes), "dropped 2 unreferenced nodes")) << joined(result.notes);
  EXPECT_TRUE(contains(joined(result.notes), ": 0, 4"));
  EXPECT_EQ(result.mesh.nodes.row(1), (Eigen::RowVector3d(0, 0, 1)));  // second in the file's list, not tag 2
  EXPECT_EQ(result.mesh.nodes.row(3), (Eigen::RowVector3d(1, 0, 0)));
}

TEST(Units, ASizeThatCannotBeMetresIsAskedAbout) {
  const TemporaryFile file(msh_2(two_cells, 2), ".msh");
  EXPECT_TRUE(contains(joined(import_file(file.path, 1000).warnings), "mesh.scale_to_m = 1000"));
  EXPECT_TRUE(contains(joined(import_file(file.path, 1e-5).warnings), "mesh.scale_to_m"));
  EXPECT_FALSE(contains(joined(import_file(file.path, 0.1).warnings), "mesh.scale_to_m"));
  // Without a scene there is no scale to ask about.
  const TemporaryFile millimetres(msh_2(two_cells, 2, "1 0 0 0\n2 99 0 0\n3 0 99 0\n4 0 0 99\n5 99 99 99\n"), ".msh");
  Scene scene;
  scene.mesh.file = millimetres.path;
  EXPECT_TRUE(make_mesh(scene, true).warnings.empty());
  EXPECT_FALSE(make_mesh(scene).warnings.empty());
}

}  // namespace
}  // namespace phynness::test
