// Claim: the same body in every format gives the same mesh: node numbers in the file's order, cells, hash.
#include "mesh_under_test.hpp"
#include "small_files.hpp"

namespace phynness::test {
namespace {

TEST(Readers, GiveTheSameMeshFromEveryFormat) {
  const std::string hash = mesh_hash(import_bytes(msh_2(two_cells, 2), ".msh").mesh);
  const std::pair<const char*, std::string> files[] = {{".msh", small_msh_1},
                                                       {".msh", small_msh_2},
                                                       {".msh", small_msh_4},
                                                       {".vtk", small_vtk_4},
                                                       {".VTK", small_vtk_5},
                                                       {".msh", small_msh_2_binary(false)},
                                                       {".msh", small_msh_2_binary(true)},
                                                       {".msh", small_msh_4_binary(false)},
                                                       {".msh", small_msh_4_binary(true)},
                                                       {".vtk", small_vtk_binary()}};
  int number = 0;
  for (const auto& [extension, bytes] : files) {
    SCOPED_TRACE(number++);
    const MeshResult result = import_bytes(bytes, extension);
    EXPECT_EQ(mesh_hash(result.mesh), hash);
    EXPECT_EQ(result.mesh.nodes.row(4), (Eigen::RowVector3d(1, 1, 1)));
  }
}

TEST(Readers, TakeWindowsLineEndings) {
  std::string windows;
  for (const char c : small_msh_4) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(mesh_hash(import_bytes(windows, ".msh").mesh), mesh_hash(import_bytes(small_msh_4, ".msh").mesh));
}

TEST(Readers, TurnPhysicalGroupsIntoNodeLists) {
  const std::vector<std::int32_t> face{0, 1, 2};
  EXPECT_EQ(import_bytes(small_msh_1, ".msh").mesh.groups.at("7"), face);
  EXPECT_EQ(import_bytes(small_msh_2, ".msh").mesh.groups.at("hilum"), face);
  EXPECT_EQ(import_bytes(small_msh_4, ".msh").mesh.groups.at("hilum"), face);
}

TEST(Readers, SayWhenATagMeansTwoGroups) {
  const MeshResult result = import_bytes(msh_2("1 2 2 7 1 1 2 3\n2 4 2 7 1 1 2 3 4\n3 4 2 0 1 2 5 3 4\n", 3), ".msh");
  EXPECT_EQ(result.mesh.groups.at("surface 7"), (std::vector<std::int32_t>{0, 1, 2}));
  EXPECT_EQ(result.mesh.groups.at("volume 7"), (std::vector<std::int32_t>{0, 1, 2, 3}));
  EXPECT_EQ(result.mesh.groups.at("7"), (std::vector<std::int32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(contains(joined(result.notes), "'surface 7'"));
}

TEST(Readers, ScaleToMetres) {
  const TemporaryFile file(small_vtk_4, ".vtk");
  EXPECT_NEAR(import_file(file.path, 0.1).quality.volume_m3, 0.5e-3, 1e-15);
}

}  // namespace
}  // namespace phynness::test
