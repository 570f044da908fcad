// Claim: every defect of a file results in an Error with place and defect, and never in a crash, a hang, a huge
// allocation or an incomplete mesh. All truncations of a small file are tried; the fuzz target of
// mesh files changes bytes.
#include "mesh_under_test.hpp"
#include "small_files.hpp"

namespace phynness::test {
namespace {

void expect_every_truncation_refused(const std::string& bytes, const char* extension) {
  // The last byte is a line break that some formats can do without.
  for (std::size_t n = 0; n + 1 < bytes.size(); ++n)
    EXPECT_NE(import_error(bytes.substr(0, n), extension), "") << extension << " cut to " << n << " bytes";
}

TEST(DamagedFiles, EveryTruncationOfMsh1IsRefused) { expect_every_truncation_refused(small_msh_1, ".msh"); }
TEST(DamagedFiles, EveryTruncationOfMsh2IsRefused) { expect_every_truncation_refused(small_msh_2, ".msh"); }
TEST(DamagedFiles, EveryTruncationOfMsh4IsRefused) { expect_every_truncation_refused(small_msh_4, ".msh"); }
TEST(DamagedFiles, EveryTruncationOfBinaryMshIsRefused) {
  expect_every_truncation_refused(small_msh_2_binary(false), ".msh");
  expect_every_truncation_refused(small_msh_4_binary(false), ".msh");
}
TEST(DamagedFiles, EveryTruncationOfVtkIsRefused) {
  expect_every_truncation_refused(small_vtk_4, ".vtk");
  expect_every_truncation_refused(small_vtk_5, ".vtk");
  expect_every_truncation_refused(small_vtk_binary(), ".vtk");
}
TEST(DamagedFiles, EveryTruncationOfASurfaceIsRefused) {
  // Cut inside the last corner, "-5" becomes "-": no number.
  expect_every_truncation_refused(cube_obj, ".obj");
}

TEST(DamagedFiles, HugeCountsAreRefusedBeforeAnythingIsAllocated) {
  expect_names(import_error("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n999999999999\n1 0 0 0\n$EndNodes\n", ".msh"),
               {"declares 999999999999 nodes"});
}

struct Case {
  const char* extension;
  std::string bytes, part;
};

TEST(DamagedFiles, MessagesNameTheDefect) {
  const std::string cell_10 = "1 11 2 0 1 1 2 3 4 5 1 2 3 4 5\n";
  const Case cases[] = {
      {".msh", "", "is empty"},
      {".msh", "hello world\n", "not a gmsh mesh"},
      {".msh", "$MeshFormat\n3.0 0 8\n$EndMeshFormat\n", "unsupported .msh version: 3.0"},
      {".msh", msh_2("1 4 2 0 1 1 2 3 9\n", 1), "uses a node that is not in the file's node list: node 9"},
      {".msh", msh_2(cell_10, 1), "is not of first order"},
      {".msh", msh_2("1 15 2 0 1 1\n", 1), "neither tetrahedra nor triangles"},
      {".msh", msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n2 0 1 0\n4 0 0 1\n5 1 1 1\n"),
       "two nodes have the same number: 2"},
      {".msh", msh_2(two_cells, 2, "1 0 0 0\n2 1 0 0\n3 0 1,5 0\n4 0 0 1\n5 1 1 1\n"), "expected a number"},
      {".vtk", "VTKFile type=\"UnstructuredGrid\"\n", "not a legacy VTK file"},
      {".vtk", small_vtk_4 + "7\n", "more values than it declares"},
      {".vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n", "unsupported kind of data set"},
      {".obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", "not defined above"},
      {".obj", "v 0 0 0\n", "neither tetrahedra nor triangles"},
      {".stl", "solid x\nendsolid x\n", "neither tetrahedra nor triangles"},
      {".3mf", "PK\n", "unknown kind"},
      {".vtp", "<VTKFile type=\"PolyData\">\n", "meshio convert"}};
  for (const Case& c : cases) expect_names(import_error(c.bytes, c.extension), {c.part});
  const TemporaryFile file(msh_2("1 4 2 0 1 1 2 x 4\n", 1), ".msh");
  EXPECT_TRUE(contains(error_of([&] { import_file(file.path); }), file.path.filename().string() + ":14: "));
}

TEST(DamagedFiles, AMissingFileIsNamed) {
  EXPECT_TRUE(contains(error_of([] { import_file("/nonexistent/liver.msh"); }), "/nonexistent/liver.msh"));
}

}  // namespace
}  // namespace phynness::test
