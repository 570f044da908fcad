// Claim: what write_msh writes comes back through make_mesh with the same node numbers, cells, groups and
// hash.
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

TEST(WriteMsh, SaysWhichFileItCannotWrite) {
  const Mesh mesh = import_bytes(msh_2(two_cells, 2), ".msh").mesh;
  const std::string message = error_of([&] { write_msh(mesh, nullptr, "/nonexistent/folder/mesh.msh"); });
  EXPECT_TRUE(contains(message, "/nonexistent/folder/mesh.msh")) << message;
}

}  // namespace
}  // namespace phynness::test
