// Claims: a closed surface is filled exactly; sharp edges survive remeshing; open, inside-out and
// self-crossing surfaces are refused or repaired by name.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh_under_test.hpp"
#include "small_files.hpp"
#include "surface/surface.hpp"

namespace phynness::test {
namespace {

MeshResult fill_cube(const std::string& obj, std::optional<double> edge_m = {}) {
  const TemporaryFile file(obj, ".obj");
  Scene scene;
  scene.mesh.file = file.path;
  scene.mesh.target_size_m = edge_m;
  return make_mesh(scene);
}

TEST(Surfaces, ACubeIsFilledExactly) {
  SKIP_WITHOUT_GMSH();
  const MeshResult result = fill_cube(cube_obj);
  EXPECT_NEAR(result.quality.volume_m3, 1, 1e-12);
  EXPECT_TRUE(contains(joined(result.notes), "split 6 faces"));
}

TEST(Surfaces, RemeshingKeepsSharpEdges) {
  SKIP_WITHOUT_GMSH();
  const MeshResult result = fill_cube(cube_obj, 0.2);
  EXPECT_NEAR(result.quality.volume_m3, 1,
              1e-6);  // nothing is cut off the edges; only flat cells may be peeled
  EXPECT_NEAR(result.quality.mean_edge_m, 0.2, 0.06);
  EXPECT_NEAR(fill_cube(cube_obj, 1).quality.volume_m3, 1, 1e-6);
}

// Claim: sharp edges of an extent below the edge length are not kept, as the ridges of a flat pyramid of 1/100 on a
// face of the cube, but if they are a loop, as the foot of a steep one.
TEST(Surfaces, RemeshingRemovesSmallFeaturesWithoutLoops) {
  SKIP_WITHOUT_GMSH();
  const auto shortest_edge = [](const std::string& height) {
    const Mesh mesh = fill_cube(
                          "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                          "v 0.5 0.5 1\nv 0.51 0.5 1\nv 0.51 0.51 1\nv 0.5 0.51 1\nv 0.505 0.505 " +
                              height +
                              "\nf 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 6 10 9\nf 6 7 11 10\n"
                              "f 7 8 12 11\nf 8 5 9 12\nf 9 10 13\nf 10 11 13\nf 11 12 13\nf 12 9 13\n",
                          0.2)
                          .mesh;
    double shortest = 1;
    for (const auto triangle : mesh.surface.rowwise())
      for (int k = 0; k < 3; ++k)
        shortest = std::min(shortest, (mesh.nodes.row(triangle[k]) - mesh.nodes.row(triangle[(k + 1) % 3])).norm());
    return shortest;
  };
  // Lengths are 4/5 to 4/3 of 0.2 but where a collapse would turn a triangle over.
  EXPECT_GT(shortest_edge("1.005"), 0.05);
  EXPECT_LT(shortest_edge("1.05"), 0.02);
}

TEST(Surfaces, InsideOutIsTurnedWithANote) {
  SKIP_WITHOUT_GMSH();
  const std::string inside_out = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
  const MeshResult result = fill_cube(inside_out);
  EXPECT_NEAR(result.quality.volume_m3, 1.0 / 6, 1e-12);
  EXPECT_TRUE(contains(joined(result.notes), "normals pointed inward")) << joined(result.notes);
}

TEST(Surfaces, AStrayTriangleIsTurnedWithANote) {
  SKIP_WITHOUT_GMSH();
  const std::string stray = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n";
  const MeshResult result = fill_cube(stray);
  EXPECT_NEAR(result.quality.volume_m3, 1.0 / 6, 1e-12);
  EXPECT_TRUE(contains(joined(result.notes), "turned")) << joined(result.notes);
}

TEST(Surfaces, AHoleIsCounted) {
  const std::string open = cube_obj.substr(0, cube_obj.rfind("f "));
  const std::string message = error_of([&] { fill_cube(open); });
  EXPECT_TRUE(contains(message, "the surface is open") && contains(message, "4 open edges")) << message;
  EXPECT_TRUE(contains(message, "close the holes") && contains(message, "thickness_m")) << message;
}

/// The cube, moved and scaled, with corners of its own.
std::string another_cube(double size, double at) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    const int x = (i + 1) / 2 % 2, y = i / 2 % 2, z = i / 4;
    text +=
        "v " + std::to_string(at + size * x) + " " + std::to_string(size * y) + " " + std::to_string(size * z) + "\n";
  }
  return text + "f -8 -5 -6 -7\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n";
}

TEST(Surfaces, OfSeveralClosedPiecesAreCountedAndTheDroppedOnesToldBySize) {
  const std::string pieces = another_cube(0.5, -2) + another_cube(1, 0) + another_cube(0.1, 3);
  expect_names(import_error(pieces, ".obj"), {"several closed surfaces: 3 components of 12, 12 and 12"});
  const std::string open = pieces.substr(0, pieces.rfind("f "));
  expect_names(import_error(open, ".obj"), {"the surface is open", "4 open edges", "remedy: set mesh.repair = true"});
  SKIP_WITHOUT_GMSH();
  const MeshResult result = import_bytes(pieces, ".obj", true);
  EXPECT_NEAR(result.quality.volume_m3, 1, 1e-12);
  EXPECT_TRUE(contains(joined(result.notes), "triangles, 1 m^3; dropped 0.125, 0.001 m^3")) << joined(result.notes);
}

// Vertices of a seam differ in the last digits of the file.
TEST(Surfaces, WithVerticesThatAreNearlyEqualAreClosedOnRequest) {
  SKIP_WITHOUT_GMSH();
  std::string seam = cube_obj;
  seam.replace(seam.find("f 2 3 7 6"), 9, "f 2 3 10 9");
  seam.insert(seam.find("vn"), "v 1.0000001 0 1\nv 1 1.0000001 1\n");
  seam.replace(seam.find("f -8 -4 -1 -5"), 13, "f 1 5 8 4");
  expect_names(import_error(seam, ".obj"), {"2 nodes are within 1e-07 m", "remedy: set mesh.repair = true to merge"});
  EXPECT_NEAR(import_bytes(seam, ".obj", true).quality.volume_m3, 1, 1e-6);
}

TEST(Surfaces, AFlatSurfaceHasNoInside) {
  const std::string flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  EXPECT_TRUE(contains(error_of([&] { fill_cube(flat); }), "encloses no volume"));
}

// A sheet that is thinner than rounding errors of its size. It is an error of the file, not of the program.
TEST(Surfaces, AnInsideThatCannotBeFilledIsAnErrorOfTheInput) {
  SKIP_WITHOUT_GMSH();
  std::string sheet = cube_obj;
  for (std::size_t at = 0; (at = sheet.find(" 1\n", at)) != std::string::npos;) sheet.replace(at, 3, " 1e-9\n");
  expect_names(message_of([&] { fill_cube(sheet); }), {"the inside of the surface cannot be filled"});
}

// Claim: of slivers at a clump of short edges of a file the remedy is new triangles, with which there are none.
TEST(Surfaces, WithAClumpOfShortEdgesNeedNewTriangles) {
  SKIP_WITHOUT_GMSH();
  const std::string clump =
      "v .1 0 0\nv 0 .1 0\nv -.1 0 0\nv 0 -.1 0\nv 0 0 -.1\nf 5 2 1\nf 5 3 2\nf 5 4 3\nf 5 1 4\n"
      "v .001 0 .099\nv 0 .001 .099\nv -.001 0 .099\nv 0 -.001 .099\nv 0 0 .1\n"
      "f 10 6 7\nf 10 7 8\nf 10 8 9\nf 10 9 6\n"
      "f 6 1 2\nf 6 2 7\nf 7 2 3\nf 7 3 8\nf 8 3 4\nf 8 4 9\nf 9 4 1\nf 9 1 6\n";
  expect_names(joined(fill_cube(clump).warnings), {"slivers", "short edges there", "mesh.target_size_m makes new"});
  EXPECT_EQ(fill_cube(clump, 0.04).quality.n_slivers, 0);
}

/// A prism with regular ends of n corners.
std::string prism_obj(int n, double radius, double length) {
  std::string text, bottom = "f", top = "f", sides;
  for (int i = 0; i < 2 * n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    text += "v " + std::to_string(radius * std::cos(angle)) + " " + std::to_string(radius * std::sin(angle)) + " " +
            std::to_string(i < n ? 0 : length) + "\n";
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    bottom += " " + std::to_string(n - i), top += " " + std::to_string(n + i + 1);
    for (const int node : {i, next, n + next, n + i}) sides += (node == i ? "f " : " ") + std::to_string(node + 1);
    sides += "\n";
  }
  return text + bottom + "\n" + top + "\n" + sides;
}

// Triangles in a plane have signed volumes of rounding errors, which are no intersections: nothing is smoothed.
TEST(Surfaces, OfFlatFacesDoNotIntersectThemselves) {
  SKIP_WITHOUT_GMSH();
  for (const int n : {8, 12})
    for (const double edge_m : {0.007, 0.006, 0.005}) {
      const MeshResult result = fill_cube(prism_obj(n, 0.025, 0.1), edge_m);
      EXPECT_FALSE(contains(joined(result.notes), "intersected itself")) << n << " " << edge_m << joined(result.notes);
    }
}

TEST(Surfaces, ThatIntersectAreFound) {
  // A thin spike through a triangle, and the same spike that ends a thousandth of its length before it.
  meshes::Surface surface;
  surface.nodes.resize(6, 3);
  surface.triangles.resize(2, 3);
  surface.triangles << 0, 1, 2, 3, 4, 5;
  for (const double tip : {-0.001, 0.001}) {
    surface.nodes << -1, -1, 0, 1, -1, 0, 0, 1, 0, 0, 0, tip, 0.001, 0, 1, 0, 0.001, 1;
    EXPECT_EQ(meshes::crossing_triangles(surface).size(), tip < 0 ? 1u : 0u) << tip;
  }
}

TEST(Surfaces, OversizedWishesAreRefusedAtOnce) {
  expect_names(error_of([] { fill_cube(cube_obj, 1e-4); }), {"0.0001 m", "scale_to_m"});
}

}  // namespace
}  // namespace phynness::test
