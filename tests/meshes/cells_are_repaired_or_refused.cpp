// Claims: cells with opposite numbering are flipped with a note. Flat, overlapping or separate cells, NaN coordinates
// and pinched bodies are refused with their numbers. Unreferenced nodes are dropped with a note, and the order of all
// others is kept.
#include "mesh_under_test.hpp"

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
  const std::string message = error_of(
      [] { import_bytes(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0.1 0.1 0.1\n"), ".msh"); });
  EXPECT_TRUE(contains(message, "inverted") && contains(message, "2 cells: 0, 1")) << message;
}

TEST(Cells, WithoutVolumeAreRefusedWithTheirNodes) {
  const std::string message =
      error_of([] { import_bytes(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 1 1 1\n"), ".msh"); });
  EXPECT_TRUE(contains(message, "cell 0 has no volume") && contains(message, "nodes 0 1 2 3")) << message;
}

TEST(Cells, WithNanCoordinatesAreRefused) {
  const std::string message =
      error_of([] { import_bytes(msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 nan 1\n"), ".msh"); });
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
  const std::string message = error_of([&] { import_bytes(msh_2(cells, 3, nodes, 9), ".msh"); });
  EXPECT_TRUE(contains(message, "2 components of 2 and 1 cells")) << message;
  const MeshResult result = import_bytes(msh_2(cells, 3, nodes, 9), ".msh", true);
  EXPECT_EQ(result.mesh.n_cells(), 2);
  EXPECT_TRUE(contains(joined(result.notes), "kept the largest of 2 components"));
}

TEST(Cells, TouchingAlongAnEdgeOnlyAreNoManifold) {
  const std::string nodes = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 -1 0\n6 0 0 -1\n";
  const std::string message =
      error_of([&] { import_bytes(msh_2("1 4 2 0 1 1 2 3 4\n2 4 2 0 1 1 2 5 6\n", 2, nodes, 6), ".msh"); });
  EXPECT_TRUE(contains(message, "1 non-manifold edge (nodes 0-1)")) << message;
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
}

}  // namespace
}  // namespace phynness::test
