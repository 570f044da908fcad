// Claim: the same body in every format gives the same mesh: node numbers in the file's order, cells, hash. Lines may
// end in any of three ways, words may be in the forms that other programs write, and meshes may be in parts.
#include "mesh_under_test.hpp"
#include "read/raw_mesh.hpp"
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

TEST(Readers, TakeAnyLineEndingsAndTheMarkOfUtf8) {
  const std::string x = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", faces = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  const std::string ply =
      "ply \nformat ascii 1.0\nelement vertex 4\nproperty float z\nproperty float y\nproperty float x\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header \n";
  const std::pair<const char*, std::string> files[] = {
      {".msh", small_msh_4},
      {".vtk", small_vtk_5},
      {".inp", "*NODE\n1, 0, 0, 0\n2, 1\n3, 0, 1\n4, 0, 0, 1\n*ELEMENT, TYPE=C3D4,\n1, 1, 2, 3, 4\n"},
      {".obj", "v 0 0 0 # a\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1/1/1 3//1 -3/9 # b\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"},
      {".off", "off 4 4 0 # counts\n" + x + faces},
      {".ply", ply + x + faces},
      {".stl",
       "solid a\nfacet normal nan 0 0\nouter\tloop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
       "endfacet\nendsolid a\n"}};
  for (const auto& [extension, text] : files) {
    SCOPED_TRACE(extension);
    const auto read = [&, &ending = extension](const std::string& bytes, const char* mark = "") {
      return meshes::read_mesh_file(TemporaryFile(mark + bytes, ending).path);
    };
    const meshes::RawMesh expected = read(text);
    EXPECT_GT(expected.tetrahedra.size() + expected.triangles.size(), 0u);
    for (const std::string end : {"\n", "\r\n", "\r"})
      for (const char* mark : {"", "\xef\xbb\xbf"}) {
        std::string ended;
        for (const char c : text) ended += c == '\n' ? end : std::string(1, c);
        const meshes::RawMesh raw = read(ended, mark);
        EXPECT_EQ(raw.nodes, expected.nodes);
        EXPECT_EQ(raw.tetrahedra, expected.tetrahedra);
        EXPECT_EQ(raw.triangles, expected.triangles);
      }
    EXPECT_TRUE(contains(error_of([&, &bytes = text] { read(bytes, "\xff\xfe"); }), "UTF-16"));
  }
}

TEST(Readers, TakePartitionedMeshes) {
  std::string parts = small_msh_4;  // the parts of surface 3 and volume 1 are surface 4 and volumes 5 and 6
  const auto turn = [&](const std::string& from, const std::string& to) {
    parts.replace(parts.find(from), from.size(), to);
  };
  turn("$EndEntities\n",
       "$EndEntities\n$PartitionedEntities\n2\n1\n9 2\n0 0 1 2\n4 2 3 1 1 0 0 0 1 1 0 1 7 0\n"
       "5 3 1 1 1 0 0 0 1 1 1 0 1 4\n6 3 1 2 1 2 0 0 0 1 1 1 0 0\n$EndPartitionedEntities\n");
  turn("2 3 0 3", "2 4 0 3");
  turn("3 1 0 2\n4", "3 5 0 2\n4");
  turn("2 3 1 3\n2 3 2 1\n1 1 2 3\n3 1 4 2\n2 1 2 3 4\n", "3 3 1 3\n2 4 2 1\n1 1 2 3\n3 5 4 1\n2 1 2 3 4\n3 6 4 1\n");
  const MeshResult result = import_bytes(parts, ".msh");
  EXPECT_EQ(mesh_hash(result.mesh), mesh_hash(import_bytes(small_msh_4, ".msh").mesh));
  EXPECT_EQ(result.mesh.groups.at("hilum"), (std::vector<std::int32_t>{0, 1, 2}));
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
