// Claim: each selector picks the nodes its definition says, those exactly on its border included; whatever
// cannot be meant is refused with file and line. The body is a 3 x 3 x 3 grid of nodes with spacing 1,
// numbered x first.
#include <Eigen/LU>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

using Nodes = std::vector<std::int32_t>;
constexpr std::int32_t center = 13;

Mesh grid() {
  Mesh mesh;
  mesh.nodes.resize(27, 3);
  for (int i = 0; i < 27; ++i) mesh.nodes.row(i) << i % 3, i / 3 % 3, i / 9;
  const int paths[6][2] = {{1, 3}, {1, 9}, {3, 1},
                           {3, 9}, {9, 1}, {9, 3}};  // Kuhn's six tetrahedra of a cube
  std::vector<std::array<int, 4>> cells;
  for (int c = 0; c < 8; ++c)
    for (const auto& [p, q] : paths) {
      const int a = c % 2 + 3 * (c / 2 % 2) + 9 * (c / 4);
      std::array<int, 4> cell{a, a + p, a + p + q, a + 13};
      const Eigen::RowVector3d u = mesh.nodes.row(cell[1]) - mesh.nodes.row(a),
                               v = mesh.nodes.row(cell[2]) - mesh.nodes.row(a),
                               w = mesh.nodes.row(cell[3]) - mesh.nodes.row(a);
      Eigen::Matrix3d m;
      m << u, v, w;
      if (m.determinant() < 0) std::swap(cell[2], cell[3]);
      cells.push_back(cell);
    }
  mesh.cells.resize(static_cast<Eigen::Index>(cells.size()), 4);
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (int k = 0; k < 4; ++k) mesh.cells(static_cast<Eigen::Index>(c), k) = cells[c][k];
  mesh.surface = boundary_triangles(mesh.cells);
  mesh.groups["corners"] = {0, 2, 6, 8};
  return mesh;
}

Selector selector(Selector::Kind kind, Vec3 a = {}, Vec3 b = {}, double radius_m = 0) {
  Selector s;
  s.kind = kind;
  s.a = a;
  s.b = b;
  s.radius_m = radius_m;
  s.where = {"scene.toml", 7};
  return s;
}

Scene scene_with(Selection output) {
  Scene scene;
  scene.fixed = {selector(Selector::Kind::box, {0, 0, 0}, {2, 2, 0})};
  scene.active = {selector(Selector::Kind::free_surface)};
  scene.output = std::move(output);
  scene.fixed_where = {"scene.toml", 4};
  scene.active_where = {"scene.toml", 5};
  scene.output_where = {"scene.toml", 6};
  return scene;
}

Nodes selected(const Selector& s) { return resolve_selections(scene_with({s}), grid()).output; }

TEST(Selections, BoxTakesItsFacesIn) {
  EXPECT_EQ(selected(selector(Selector::Kind::box, {1, 1, 1}, {2, 2, 1})), (Nodes{13, 14, 16, 17}));
}

TEST(Selections, NodesAFewRoundingErrorsOffTheFaceCountIn) {
  EXPECT_EQ(selected(selector(Selector::Kind::box, {1 + 1e-12, 1, 1}, {2, 2, 1})).size(), 4u);
  EXPECT_EQ(selected(selector(Selector::Kind::box, {1 + 1e-6, 1, 1}, {2, 2, 1})).size(), 2u);
}

TEST(Selections, FractionsAreOfTheBoundingBox) {
  Selector s = selector(Selector::Kind::box, {0.5, 0.5, 0.5}, {1, 1, 0.5});
  s.fraction = true;
  EXPECT_EQ(selected(s), (Nodes{13, 14, 16, 17}));
}

TEST(Selections, Sphere) {
  EXPECT_EQ(selected(selector(Selector::Kind::sphere, {1, 1, 1}, {}, 1)), (Nodes{4, 10, 12, 13, 14, 16, 22}));
}

TEST(Selections, PlaneTakesBothSidesWithinItsTolerance) {
  EXPECT_EQ(selected(selector(Selector::Kind::plane, {0, 0, 1.5}, {0, 0, 2}, 0.5)).size(), 18u);
  EXPECT_EQ(selected(selector(Selector::Kind::plane, {0, 0, 1}, {0, 0, -3}, 0)).size(), 9u);
}

TEST(Selections, HalfSpaceLiesBehindItsNormal) {
  EXPECT_EQ(selected(selector(Selector::Kind::half_space, {1, 0, 0}, {5, 0, 0})).size(), 18u);
  EXPECT_EQ(selected(selector(Selector::Kind::half_space, {1.5, 0, 0}, {-1, 0, 0})).size(), 9u);
}

TEST(Selections, NearestIsOneNode) {
  Selector s = selector(Selector::Kind::nearest, {1.2, 1.1, 0.9});
  EXPECT_EQ(selected(s), (Nodes{center}));
  s.surface_only = true;
  EXPECT_EQ(selected(s), (Nodes{14}));  // the middle of the face at x = 2
}

TEST(Selections, GroupsAndNodeLists) {
  Selector s = selector(Selector::Kind::group);
  s.group = "corners";
  EXPECT_EQ(selected(s), (Nodes{0, 2, 6, 8}));
  s = selector(Selector::Kind::nodes);
  s.nodes = {5, 3, 5};
  EXPECT_EQ(selected(s), (Nodes{3, 5}));
}

TEST(Selections, SurfaceFreeAndAll) {
  EXPECT_EQ(selected(selector(Selector::Kind::surface)).size(), 26u);
  EXPECT_EQ(selected(selector(Selector::Kind::free_surface)).size(), 17u);
  EXPECT_EQ(selected(selector(Selector::Kind::free_nodes)).size(), 18u);
  EXPECT_EQ(selected(selector(Selector::Kind::all)).size(), 27u);
  Selector s = selector(Selector::Kind::all);
  s.surface_only = true;
  EXPECT_EQ(selected(s).size(), 26u);
}

TEST(Selections, AListIsTheUnionOfItsSelectors) {
  Selector one = selector(Selector::Kind::nodes), two = one;
  one.nodes = {1, 2};
  two.nodes = {2, 3};
  EXPECT_EQ(resolve_selections(scene_with({one, two}), grid()).output, (Nodes{1, 2, 3}));
}

TEST(Selections, OutputMayHoldFixedNodes) {
  EXPECT_EQ(resolve_selections(scene_with({selector(Selector::Kind::all)}), grid()).output.front(), 0);
}

TEST(Selections, MistakesAreNamedWithTheirLine) {
  const auto message = [](const Scene& scene) {
    return error_of([&] { resolve_selections(scene, grid()); });
  };
  const Scene good = scene_with({selector(Selector::Kind::all)});
  EXPECT_EQ(message(good), "");

  Scene scene = good;
  scene.output = {selector(Selector::Kind::sphere, {9, 9, 9}, {}, 0.1)};
  EXPECT_TRUE(contains(message(scene), "scene.toml:7: a selector of the output nodes selects no node"))
      << message(scene);
  EXPECT_TRUE(contains(message(scene), "(2, 2, 2) m"));

  scene = good;
  scene.active = {selector(Selector::Kind::surface)};
  EXPECT_TRUE(contains(message(scene), "scene.toml:5: active nodes that are also fixed") &&
              contains(message(scene), "9 nodes: 0"))
      << message(scene);

  scene = good;
  scene.fixed.clear();
  EXPECT_TRUE(contains(message(scene), "scene.toml:4: there are no fixed nodes")) << message(scene);

  scene = good;
  scene.output[0].kind = Selector::Kind::group;
  scene.output[0].group = "hilum";
  EXPECT_TRUE(contains(message(scene), "no physical group") && contains(message(scene), "'corners'"))
      << message(scene);

  scene = good;
  scene.output[0].kind = Selector::Kind::nodes;
  scene.output[0].nodes = {3, 27};
  EXPECT_TRUE(contains(message(scene), "out of range: 27") && contains(message(scene), "0 to 26"))
      << message(scene);

  scene = good;
  scene.fixed = {selector(Selector::Kind::free_nodes)};
  EXPECT_TRUE(contains(message(scene), "what is not fixed")) << message(scene);

  scene = good;
  scene.output = {selector(Selector::Kind::plane)};
  EXPECT_TRUE(contains(message(scene), "normal is zero")) << message(scene);
}

}  // namespace
}  // namespace phynness::test
