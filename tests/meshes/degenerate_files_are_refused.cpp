// Claim: a file whose triangles or cells are points, lines, repeated, too far away or missing is refused with a
// message, in every format and for filling, repair and shells. None ends the program.
#include <sstream>

#include "mesh_under_test.hpp"
#include "read/file_mesh.hpp"
#include "surface/surface.hpp"

namespace phynness::test {
namespace {

using meshes::RawMesh;

struct Degenerate {
  const char* name;
  std::vector<std::array<double, 3>> nodes;
  std::vector<meshes::Triangle> triangles;
};

void PrintTo(const Degenerate& file, std::ostream* stream) { *stream << file.name; }

const std::vector<meshes::Triangle> closed = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
const std::vector<Degenerate> files = {
    {"OnePoint", {{0, 0, 0}}, {{0, 0, 0}}},
    {"OnePointManyTimes", {{1, 2, 3}}, {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}},
    {"Lines", {{0, 0, 0}, {1, 0, 0}}, {{0, 1, 0}, {1, 1, 0}}},
    {"PointsInOnePlace", {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, closed},
    {"PointsInOnePlaceAndOneElsewhere", {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 9, 9}}, {{0, 1, 2}, {0, 2, 1}}},
    {"PointsOnALine", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, closed},
    {"PointsOnAPlane", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, closed},
    {"RepeatedTriangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 1, 2}, {0, 1, 2}}},
    {"FarAway", {{0, 0, 0}, {1e300, 0, 0}, {0, 1e300, 0}, {0, 0, 1}}, closed},
    {"AsFarAsFloats", {{3e38, 3e38, 3e38}, {-3e38, 0, 0}, {0, -3e38, 0}, {0, 0, -3e38}}, closed},
    {"Infinite", {{0, 0, 0}, {INFINITY, 0, 0}, {0, 1, 0}, {0, 0, 1}}, closed},
    {"Tiny", {{0, 0, 0}, {1e-310, 0, 0}, {0, 1e-310, 0}, {0, 0, 1e-310}}, closed},
};

std::string obj(const Degenerate& file) {
  std::ostringstream text;
  for (const auto& x : file.nodes) text << "v " << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
  for (const auto& t : file.triangles) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

std::string stl(const Degenerate& file) {
  std::ostringstream text;
  text << "solid s\n";
  for (const auto& t : file.triangles) {
    text << "facet normal 0 0 1\nouter loop\n";
    for (const auto node : t) {
      const auto& x = file.nodes[static_cast<std::size_t>(node)];
      text << "vertex " << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
    }
    text << "endloop\nendfacet\n";
  }
  text << "endsolid s\n";
  return text.str();
}

std::string vtk(const Degenerate& file) {
  std::ostringstream text;
  text << "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS " << file.nodes.size() << " double\n";
  for (const auto& x : file.nodes) text << x[0] << ' ' << x[1] << ' ' << x[2] << '\n';
  text << "POLYGONS " << file.triangles.size() << ' ' << 4 * file.triangles.size() << '\n';
  for (const auto& t : file.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return text.str();
}

/// Each triangle as such, or as a cell with its last node twice.
std::string msh(const Degenerate& file, bool cells) {
  std::ostringstream text;
  text << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << file.nodes.size() << '\n';
  for (std::size_t i = 0; i < file.nodes.size(); ++i)
    text << i + 1 << ' ' << file.nodes[i][0] << ' ' << file.nodes[i][1] << ' ' << file.nodes[i][2] << '\n';
  text << "$EndNodes\n$Elements\n" << file.triangles.size() << '\n';
  for (std::size_t i = 0; i < file.triangles.size(); ++i) {
    const auto& t = file.triangles[i];
    text << i + 1 << (cells ? " 4 0 " : " 2 0 ") << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1;
    if (cells) text << ' ' << (i + 1 < file.nodes.size() ? i + 1 : 1);
    text << '\n';
  }
  text << "$EndElements\n";
  return text.str();
}

class DegenerateFile : public ::testing::TestWithParam<Degenerate> {
 protected:
  static void expect_refused(const std::string& bytes, const char* extension) {
    const TemporaryFile file(bytes, extension);
    for (const bool repair : {false, true}) {
      for (const double scale_to_m : {1.0, 0.001, 1e-300}) {
        for (const bool shell : {false, true}) {
          Scene scene;
          scene.mesh.file = file.path;
          scene.mesh.scale_to_m = scale_to_m;
          scene.mesh.repair = repair;
          if (shell) scene.mesh.thickness_m = 0.001;
          // A flat shell is a good one, and so is a tetrahedron's surface.
          const std::string message = error_of([&] {
            const MeshResult result = make_mesh(scene);
            ASSERT_TRUE(shell && result.quality.area_m2 > 0);
          });
          if (!shell) {
            EXPECT_TRUE(contains(message, "remedy: ")) << extension << ' ' << message;
          }
        }
      }
    }
  }
};

TEST_P(DegenerateFile, IsRefusedInEveryFormat) {
  expect_refused(obj(GetParam()), ".obj");
  expect_refused(stl(GetParam()), ".stl");
  expect_refused(vtk(GetParam()), ".vtk");
  expect_refused(msh(GetParam(), false), ".msh");
  expect_refused(msh(GetParam(), true), ".msh");
}

// These ask for the file's surface alone.
TEST_P(DegenerateFile, HasAnAnswerWithoutAScene) {
  const TemporaryFile file(obj(GetParam()), ".obj");
  error_of([&] { holds_open_surface(file.path); });
  error_of([&] { EXPECT_GT(make_shell(file.path).quality.area_m2, 0); });
}

INSTANTIATE_TEST_SUITE_P(Kinds, DegenerateFile, ::testing::ValuesIn(files),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(DegenerateFiles, SayWhatIsWrong) {
  const auto obj_error = [](const Degenerate& file) { return import_error(obj(file), ".obj"); };
  EXPECT_TRUE(contains(obj_error(files[0]), "the surface has no triangle with three different corners: 1 triangle"))
      << obj_error(files[0]);
  EXPECT_TRUE(contains(obj_error(files[8]), "a vertex has coordinates that are too large: node 1 at (1e+300, 0, 0) m"))
      << obj_error(files[8]);
  EXPECT_TRUE(contains(obj_error(files[8]), "check mesh.scale_to_m"));
}

// What make_mesh never asks, since readers refuse it before.
TEST(DegenerateFiles, WithoutAnythingAreRefused) {
  std::vector<std::string> notes;
  const RawMesh nothing;
  EXPECT_TRUE(contains(error_of([&] { meshes::checked_body(nothing, 1, true, "f"); }), "holds no tetrahedra"));
  EXPECT_TRUE(contains(error_of([&] { meshes::checked_surface(nothing, 1, true, "f", notes); }), "no triangle"));
  EXPECT_TRUE(contains(error_of([&] { meshes::checked_shell(nothing, 1, true, "f"); }), "no triangle"));
  RawMesh empty;
  EXPECT_TRUE(meshes::join_near_nodes(empty, true).empty());
  meshes::Surface surface;
  surface.nodes.resize(0, 3);
  surface.triangles.resize(0, 3);
  EXPECT_TRUE(meshes::crossing_triangles(surface).empty());
}

// Near is what is near beside the edges there: the cell is small, but a piece of its own.
TEST(DegenerateFiles, KeepTheCornersOfSmallCellsApart) {
  RawMesh raw;
  raw.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0}, {2 + 1e-10, 0, 0}, {2, 1e-10, 0}, {2, 0, 1e-10}};
  raw.tetrahedra = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  EXPECT_TRUE(contains(error_of([&] { meshes::checked_body(raw, 1, false, "f"); }), "2 components of 1 and 1 cells"));
  EXPECT_EQ(meshes::checked_body(raw, 1, true, "f").mesh.n_cells(), 1);
}

}  // namespace
}  // namespace phynness::test
