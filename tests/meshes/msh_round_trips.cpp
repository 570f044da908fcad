// Claim: what write_msh writes comes back through make_mesh with the same node numbers, cells, groups and hash.
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

/// What meshio finds in a file, and in the file that gmsh saves of it.
constexpr const char* reader = R"(
import sys, gmsh, meshio

def tell(file):
    mesh = meshio.read(file)
    cells = sorted((block.type, len(block.data)) for block in mesh.cells if block.type != 'vertex')
    print('', len(mesh.points), *cells, sorted(mesh.field_data))

tell(sys.argv[1])
gmsh.initialize(['-', '-v', '0'])
gmsh.open(sys.argv[1])
gmsh.write(sys.argv[2])
tell(sys.argv[2])
)";

// meshio is how most people open a mesh in Python, and gmsh how they look at it. Counts and groups must be ours in
// both.
TEST(WriteMsh, IsReadByMeshioAndSavedByGmsh) {
  SKIP_WITHOUT_GMSH();
  if (std::system("/usr/bin/python3 -c 'import gmsh, meshio' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-meshio or gmsh.py is missing";
  const TemporaryFile script(reader, ".py");
  for (const Shape kind : {Shape::liver, Shape::block, Shape::cylinder, Shape::tube, Shape::drain}) {
    Scene scene;
    scene.mesh.shape = kind;
    scene.mesh.target_nodes = 200;
    if (kind == Shape::drain) scene.mesh.thickness_m = 1e-3;
    const Mesh mesh = make_mesh(scene).mesh;
    for (const bool with_sets : {false, true}) {
      NodeSets sets;
      sets.fixed = {0, 1}, sets.active = {2}, sets.output = {2, 3};
      const TemporaryFile file("", ".msh"), saved("", ".msh"), said("", ".txt");
      write_msh(mesh, with_sets ? &sets : nullptr, file.path);
      std::string call = "/usr/bin/python3";
      for (const auto* path : {&script.path, &file.path, &saved.path}) call += " " + path->string();
      EXPECT_EQ(std::system((call + " > " + said.path.string() + " 2>&1").c_str()), 0);
      std::ostringstream expected, found;
      for (int reading = 0; reading < 2; ++reading) {
        expected << "\n " << mesh.n_nodes();  // meshio begins with an empty line
        if (mesh.cells.cols() == 4) expected << " ('tetra', " << mesh.cells.rows() << ')';
        expected << " ('triangle', " << mesh.surface.rows() << ") [" << (with_sets ? "'phynness_active', " : "")
                 << (mesh.cells.cols() == 4 ? "'phynness_body', " : "")
                 << (with_sets ? "'phynness_fixed', 'phynness_output', " : "") << "'phynness_surface']\n";
      }
      found << std::ifstream(said.path).rdbuf();
      EXPECT_EQ(found.str(), expected.str()) << name(kind);
      // gmsh writes 16 digits.
      const Mesh back = (kind == Shape::drain ? make_shell(saved.path) : import_file(saved.path)).mesh;
      EXPECT_EQ(back.cells, mesh.cells) << name(kind);
      ASSERT_EQ(back.n_nodes(), mesh.n_nodes()) << name(kind);
      EXPECT_LT((back.nodes - mesh.nodes).cwiseAbs().maxCoeff(), 1e-15) << name(kind);
      if (kind == Shape::liver) {
        EXPECT_EQ(mesh_hash(import_file(file.path).mesh), mesh_hash(mesh));
      }
    }
  }
}

TEST(WriteMsh, SaysWhichFileItCannotWrite) {
  const Mesh mesh = import_bytes(msh_2(two_cells, 2), ".msh").mesh;
  expect_names(error_of([&] { write_msh(mesh, nullptr, "/nonexistent/folder/mesh.msh"); }),
               {"/nonexistent/folder/mesh.msh"});
}

}  // namespace
}  // namespace phynness::test
