// Claims: the triangles of a shell may be those of any file of triangles, open or closed, in any orientation. Surfaces
// that cannot be shells are refused with the reason: several pieces, edges of three triangles, surfaces that are not
// orientable or are folded, triangles without area, walls that are too thick for their bends. A seam with duplicate
// nodes is closed.
#include <cmath>
#include <functional>
#include <numbers>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

using At = std::function<std::array<double, 3>(double s, double t)>;

std::string vertices(int n, int m, const At& at) {
  std::string text;
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= n; ++i) {
      const auto x = at(static_cast<double>(i) / n, static_cast<double>(j) / m);
      text += "v " + std::to_string(x[0]) + " " + std::to_string(x[1]) + " " + std::to_string(x[2]) + "\n";
    }
  return text;
}

/// n x m squares of two triangles over [0, 1]^2, put in space by `at`.
std::string obj(int n, int m, const At& at) {
  std::string text = vertices(n, m, at);
  for (int j = 0; j < m; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1, b = a + n + 1;
      const auto face = [&](int p, int q, int r) {
        text += "f " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(r) + "\n";
      };
      face(a, a + 1, b + 1);
      face(a, b + 1, b);
    }
  return text;
}

std::array<double, 3> flat(double s, double t) { return {s, t, 0}; }

/// A tube of radius 1 and length 4; the nodes of its seam are there twice.
std::string tube() {
  return obj(24, 8, [](double s, double t) -> std::array<double, 3> {
    // Decimals of std::to_string: both ends of the seam are the same text.
    const double angle = 2 * std::numbers::pi * (s == 1 ? 0 : s);
    return {std::cos(angle), std::sin(angle), 4 * t};
  });
}

MeshResult shell_of(const std::string& bytes, double thickness_m, bool repair = false,
                    const std::string& extension = ".obj") {
  const TemporaryFile file(bytes, extension);
  Scene scene;
  scene.mesh.file = file.path;
  scene.mesh.thickness_m = thickness_m;
  scene.mesh.repair = repair;
  return make_mesh(scene);
}

std::string refusal(const std::string& bytes, double thickness_m = 0.01) {
  return error_of([&] { shell_of(bytes, thickness_m); });
}

TEST(Shells, MayBeOpen) {
  const auto result = shell_of(obj(4, 3, flat), 0.01);
  EXPECT_EQ(result.mesh.n_nodes(), 20);
  EXPECT_EQ(result.mesh.cells.cols(), 3);
  EXPECT_NEAR(result.quality.area_m2, 1, 1e-12);
  EXPECT_TRUE(result.warnings.empty()) << joined(result.warnings);
}

TEST(Shells, SeamsOfTwiceTheNodesAreClosed) {
  const auto closed = shell_of(tube(), 0.05);
  EXPECT_EQ(closed.mesh.n_nodes(), 24 * 9);
  EXPECT_TRUE(contains(joined(closed.notes), "merged 9 nodes")) << joined(closed.notes);
}

TEST(Shells, TrianglesAgainstTheirNeighboursAreTurned) {
  std::string text = obj(2, 1, flat);
  text.replace(text.rfind("f 2 6 5"), 7, "f 6 2 5");
  const auto result = shell_of(text, 0.01);
  EXPECT_TRUE(contains(joined(result.notes), "turned 1 triangle")) << joined(result.notes);
  EXPECT_NEAR(result.quality.area_m2, 1, 1e-12);
}

TEST(Shells, EdgesOfThreeTrianglesAreRefused) {
  expect_names(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n"),
               {"1 non-manifold edge"});
}

TEST(Shells, TouchingInOneNodeAreRefused) {
  expect_names(refusal("v 0 0 0\nv 1 0 0\nv 1 1 0\nv -1 0 0\nv -1 1 0\nf 1 2 3\nf 1 4 5\n"), {"1 pinched vertex"});
}

TEST(Shells, InSeveralPiecesAreRefusedOrReduced) {
  const auto pieces = obj(2, 2, flat) + "v 5 0 0\nv 6 0 0\nv 5 1 0\nf 10 11 12\n";
  expect_names(refusal(pieces), {"2 components of 8 and 1 triangles"});
  const auto kept = shell_of(pieces, 0.01, true);
  EXPECT_EQ(kept.mesh.n_cells(), 8);
  EXPECT_TRUE(contains(joined(kept.notes), "kept the largest")) << joined(kept.notes);
}

TEST(Shells, OfOneSideAreRefused) {
  constexpr int n = 20;
  std::string text;
  for (int i = 0; i < n; ++i)
    for (const double across : {-0.3, 0.3}) {
      const double angle = 2 * std::numbers::pi * i / n, r = 1 + across * std::cos(angle / 2);
      text += "v " + std::to_string(r * std::cos(angle)) + " " + std::to_string(r * std::sin(angle)) + " " +
              std::to_string(across * std::sin(angle / 2)) + "\n";
    }
  for (int i = 0; i < n; ++i) {
    // The last pair of nodes meets the first one upside down.
    const int a = 2 * i + 1, b = 2 * i + 2, c = i + 1 < n ? a + 2 : 2, d = i + 1 < n ? b + 2 : 1;
    text += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\nf " + std::to_string(b) +
            " " + std::to_string(d) + " " + std::to_string(c) + "\n";
  }
  expect_names(refusal(text), {"remedy"});
}

TEST(Shells, TrianglesWithoutAreaAreRefusedOrDropped) {
  expect_names(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.5 0 0\nf 1 2 3\nf 1 4 2\n"), {"1 triangle: 1"});
  const auto result = shell_of(obj(2, 2, flat) + "f 1 1 2\n", 0.01);
  EXPECT_TRUE(contains(joined(result.notes), "dropped 1 triangle with two equal corners")) << joined(result.notes);
  EXPECT_EQ(result.mesh.n_cells(), 8);
}

TEST(Shells, FoldedBackAreRefused) {
  expect_names(refusal("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.1 0.9 0.1\nf 1 2 3\nf 1 4 2\n"),
               {"folded back", "nodes 0 and 1"});
}

TEST(Shells, CoordinatesThatAreNotFiniteAreRefused) {
  const auto message = refusal("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
  EXPECT_FALSE(message.empty());
}

TEST(Shells, WallsTooThickForTheirBendsAreRefused) {
  EXPECT_TRUE(contains(error_of([] { shell_of(tube(), 5, true); }), "thicker than it is long"));
  expect_names(error_of([] { shell_of(tube(), 2.1, true); }), {"2.1 m", "thickness_m"});
  EXPECT_TRUE(contains(joined(shell_of(tube(), 0.7, true).warnings), "half the radius of a bend"));
  EXPECT_FALSE(contains(joined(shell_of(tube(), 0.3, true).warnings), "bend"));
  EXPECT_TRUE(shell_of(obj(2, 2, flat), 0.9).warnings.empty()) << "nothing bends here";
}

TEST(Shells, OfTetrahedraAreRefused) {
  expect_names(error_of([] { shell_of(msh_2(two_cells, 2), 0.01, false, ".msh"); }), {"remove mesh.thickness_m"});
}

TEST(Shells, AnEdgeOfFixedNodesHoldsThem) {
  // Displacements at two nodes of a line leave a body to turn about it; a clamped edge does not.
  const auto mesh = shell_of(obj(4, 3, flat), 0.01).mesh;
  EXPECT_TRUE(hold_the_body(mesh, std::vector<std::int32_t>{0, 1, 2, 3, 4}));
  EXPECT_FALSE(hold_the_body(mesh, std::vector<std::int32_t>{0, 2, 4})) << "no edge between them, all on a line";
  EXPECT_TRUE(hold_the_body(mesh, std::vector<std::int32_t>{0, 4, 12}));
  const auto solid = import_bytes(msh_2(two_cells, 2), ".msh").mesh;
  EXPECT_FALSE(hold_the_body(solid, std::vector<std::int32_t>{0, 1}));
}

TEST(Drains, CoarserThanTheirTubeAreRefusedOrWarnedOf) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::drain;
  scene.mesh.thickness_m = 0.0005;
  scene.mesh.target_nodes = 8;
  const auto mesh = make_mesh(scene);
  EXPECT_GT(mesh.mesh.n_nodes(), 8) << "so few make no tube";
  EXPECT_TRUE(contains(joined(mesh.warnings), "target_nodes is missed")) << joined(mesh.warnings);
  scene.mesh.target_nodes.reset();
  scene.mesh.target_size_m = 0.5;
  const auto message = error_of([&] { make_mesh(scene); });
  if (message.empty())
    EXPECT_TRUE(contains(joined(make_mesh(scene).warnings), "turns by more than 60 degrees"));
  else
    EXPECT_TRUE(contains(message, "smaller mesh.target_size_m")) << message;
}

}  // namespace
}  // namespace phynness::test
