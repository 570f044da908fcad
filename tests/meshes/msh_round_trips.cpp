// Claim: what write_msh writes comes back through make_mesh with the same node numbers, cells, groups and
// hash.
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

TEST(WriteMsh, RoundTripsToTheSameHashAndGroups) {
  Mesh mesh =
      import_bytes(msh_2("1 4 2 7 1 1 2 3 4\n2 4 2 0 1 2 5 3 4\n", 2,
                         "1 -0.1 1e-17 0.3333333333333333\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1.0000000000000002\n"),
                   ".msh")
          .mesh;
  mesh.groups["tip of the lobe"] = {2, 4};
  NodeSets sets;
  sets.fixed = {0};
  sets.active = {1, 2};
  sets.output = {1, 2, 3, 4};
  const TemporaryFile file("", ".msh");
  write_msh(mesh, &sets, file.path);
  const MeshResult back = import_file(file.path);
  EXPECT_EQ(mesh_hash(back.mesh), mesh_hash(mesh));
  EXPECT_EQ(back.mesh.surface, mesh.surface);
  EXPECT_EQ(back.mesh.groups.at("phynness_fixed"), sets.fixed);
  EXPECT_EQ(back.mesh.groups.at("phynness_active"), sets.active);
  EXPECT_EQ(back.mesh.groups.at("phynness_output"), sets.output);
  EXPECT_EQ(back.mesh.groups.at("tip of the lobe"), (std::vector<std::int32_t>{2, 4}));
  EXPECT_EQ(back.mesh.groups.at("7"), (std::vector<std::int32_t>{0, 1, 2, 3}));
  EXPECT_TRUE(back.notes.empty()) << joined(back.notes);
}

TEST(WriteMsh, RoundTripsAGeneratedMesh) {
  SKIP_WITHOUT_GMSH();
  const Mesh mesh = shape(Shape::liver, 200).mesh;
  const TemporaryFile file("", ".msh");
  write_msh(mesh, nullptr, file.path);
  EXPECT_EQ(mesh_hash(import_file(file.path).mesh), mesh_hash(mesh));
}

// meshio is how most people open a mesh in Python. Its counts must be ours, and its physical groups the node sets.
TEST(WriteMsh, IsReadByMeshio) {
  SKIP_WITHOUT_GMSH();
  const char* script =
      "import sys, meshio; m = meshio.read(sys.argv[1]); "
      "print(len(m.points), *sorted((c.type, len(c.data)) for c in m.cells if c.type != 'vertex'), "
      "m.field_data['phynness_surface'][1])";
  if (std::system("/usr/bin/python3 -c 'import meshio' 2>/dev/null") != 0) GTEST_SKIP() << "python3-meshio is missing";
  for (const bool with_sets : {false, true})
    for (const bool is_shell : {false, true}) {
      Mesh mesh = shape(Shape::block, 200).mesh;
      if (is_shell) mesh.cells = mesh.surface;
      NodeSets sets;
      sets.fixed = {0, 1}, sets.active = {2}, sets.output = {2, 3};
      const TemporaryFile file("", ".msh"), said("", ".txt");
      write_msh(mesh, with_sets ? &sets : nullptr, file.path);
      const std::string call = std::string("/usr/bin/python3 -c \"") + script + "\" " + file.path.string() + " > " +
                               said.path.string() + " 2>&1";
      EXPECT_EQ(std::system(call.c_str()), 0);
      std::ostringstream expected, found;
      expected << "\n" << mesh.n_nodes();  // meshio begins with an empty line
      if (mesh.cells.cols() == 4) expected << " ('tetra', " << mesh.cells.rows() << ')';
      expected << " ('triangle', " << mesh.surface.rows() << ") 2\n";
      found << std::ifstream(said.path).rdbuf();
      EXPECT_EQ(found.str(), expected.str());
    }
}

TEST(WriteMsh, SaysWhichFileItCannotWrite) {
  const Mesh mesh = import_bytes(msh_2(two_cells, 2), ".msh").mesh;
  const std::string message = error_of([&] { write_msh(mesh, nullptr, "/nonexistent/folder/mesh.msh"); });
  EXPECT_TRUE(contains(message, "/nonexistent/folder/mesh.msh")) << message;
}

}  // namespace
}  // namespace phynness::test
