// Claims: a built-in shape with a declared plane of symmetry is its own mirror image in all nodes and cells. A file
// with one half becomes the whole body. A mesh that is not symmetric is refused with the first node without an image.
#include <Eigen/Geometry>

#include "mesh_under_test.hpp"
#include "mirror.hpp"

namespace phynness::test {
namespace {

/// Fixed at one end of the axis after the mirror's, so that the fixed nodes are symmetric.
Scene symmetric_scene(Shape shape, int axis) {
  Scene scene;
  scene.mesh.shape = shape;
  scene.mesh.target_nodes = 150;
  if (shape == Shape::drain) scene.mesh.thickness_m = 0.0005;
  SymmetryPlane plane;
  plane.normal[static_cast<std::size_t>(axis)] = 1;
  scene.mesh.symmetry = plane;
  const char* const ends[] = {"[1, 0.3, 1]", "[1, 1, 0.3]", "[0.3, 1, 1]"};
  scene.fixed =
      parse_selection("{ box = { min_fraction = [0, 0, 0], max_fraction = " + std::string(ends[axis]) + " } }");
  scene.active = scene.output = parse_selection("\"free-surface\"");
  return scene;
}

class MirroredShape : public ::testing::TestWithParam<std::tuple<Shape, int>> {};

TEST_P(MirroredShape, IsItsOwnMirrorImage) {
  SKIP_WITHOUT_GMSH();
  const auto [shape, axis] = GetParam();
  const Scene scene = symmetric_scene(shape, axis);
  const Mesh mesh = make_mesh(scene).mesh;
  const auto sets = resolve_selections(scene, mesh);  // checks cells and sets
  ASSERT_TRUE(sets.mirror);
  const double middle = (mesh.nodes.col(axis).minCoeff() + mesh.nodes.col(axis).maxCoeff()) / 2;
  int on_plane = 0;
  for (std::int32_t i = 0; i < mesh.n_nodes(); ++i) {
    Eigen::RowVector3d image = mesh.nodes.row(i);
    image[axis] = 2 * middle - image[axis];
    // Made by mirroring: only rounding of coordinates below 0.1 m is left.
    EXPECT_LT((image - mesh.nodes.row(sets.mirror->image[i])).norm(), 1e-15);
    on_plane += sets.mirror->image[i] == i;
  }
  EXPECT_GT(on_plane, 4);
  EXPECT_LT(on_plane, mesh.n_nodes() / 2);
}

INSTANTIATE_TEST_SUITE_P(Shapes, MirroredShape,
                         ::testing::Combine(::testing::Values(Shape::block, Shape::cylinder, Shape::tube),
                                            ::testing::Values(0, 1, 2)),
                         [](const auto& info) {
                           return std::string(name(std::get<0>(info.param))) + "_" + "xyz"[std::get<1>(info.param)];
                         });

/// Its slit is in the upper wall: no plane of symmetry across y.
INSTANTIATE_TEST_SUITE_P(Drain, MirroredShape,
                         ::testing::Combine(::testing::Values(Shape::drain), ::testing::Values(0, 2)),
                         [](const auto& info) { return std::string(1, "xyz"[std::get<1>(info.param)]); });

TEST(AsymmetricBody, IsTheDrainAcrossItsSlit) {
  SKIP_WITHOUT_GMSH();
  const Scene scene = symmetric_scene(Shape::drain, 1);
  const Mesh mesh = make_mesh(scene).mesh;
  const auto message = error_of([&] { resolve_selections(scene, mesh); });
  EXPECT_TRUE(contains(message, "not symmetric")) << message;
}

TEST(MirroredShape, HasTheVolumeOfTheWhole) {
  SKIP_WITHOUT_GMSH();
  Scene scene = symmetric_scene(Shape::block, 1);
  scene.mesh.size_m = {0.03, 0.02, 0.01};
  EXPECT_NEAR(make_mesh(scene).quality.volume_m3, 6e-6, 1e-12 * 6e-6);  // plane faces: only rounding
}

TEST(MirroredShape, IsTheDrainThatItIsWithoutAPlane) {
  SKIP_WITHOUT_GMSH();
  // Areas differ by what triangles of 3 mm cut off a circle of 6 mm and a slit, less than a hundredth; walls
  // all face out.
  Scene scene = symmetric_scene(Shape::drain, 2);
  const Mesh mirrored = make_mesh(scene).mesh;
  scene.mesh.symmetry.reset();
  const Mesh plain = make_mesh(scene).mesh;
  const auto area = [](const Mesh& mesh) {
    double sum = 0, outward = 0;
    for (Eigen::Index t = 0; t < mesh.cells.rows(); ++t) {
      const Eigen::Vector3d a = mesh.nodes.row(mesh.cells(t, 0)), b = mesh.nodes.row(mesh.cells(t, 1)),
                            c = mesh.nodes.row(mesh.cells(t, 2)), n = (b - a).cross(c - a) / 2, m = (a + b + c) / 3;
      outward += n[0] * m[0] + n[1] * m[1] > 0 ? 1 : -1;  // the tube's axis is z
      sum += n.norm();
    }
    EXPECT_EQ(std::abs(outward), static_cast<double>(mesh.cells.rows()));
    return sum;
  };
  EXPECT_NEAR(area(mirrored), area(plain), 0.01 * area(plain));
}

TEST(AsymmetricBody, IsRefusedWithTheNodesThatHaveNoImage) {
  SKIP_WITHOUT_GMSH();
  // What gmsh makes of the whole shape: the reason why halves are mirrored.
  Scene scene = symmetric_scene(Shape::block, 0);
  Scene plain = scene;
  plain.mesh.symmetry.reset();
  const Mesh mesh = make_mesh(plain).mesh;
  const auto message = error_of([&] { resolve_selections(scene, mesh); });
  EXPECT_TRUE(contains(message, "not symmetric") && contains(message, "no mirror image within")) << message;
}

/// The octahedron's eight cells about the origin, one corner of every cell there: symmetric in x, y and z.
Mesh octahedron() {
  Mesh mesh;
  mesh.nodes.resize(7, 3);
  mesh.nodes << 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
  mesh.cells.resize(8, 4);
  for (int c = 0; c < 8; ++c) {
    const std::int32_t x = 1 + c % 2, y = 3 + c / 2 % 2, z = 5 + c / 4;
    const bool even = (c % 2 + c / 2 % 2 + c / 4) % 2 == 0;
    mesh.cells.row(c) << 0, (even ? x : y), (even ? y : x), z;
  }
  mesh.surface = boundary_triangles(mesh.cells);
  return mesh;
}

Scene octahedron_scene() {
  Scene scene = symmetric_scene(Shape::none, 0);
  scene.fixed = parse_selection("{ nodes = [3, 4, 5] }");
  return scene;
}

TEST(SymmetricBody, PairsItsNodes) {
  const auto sets = resolve_selections(octahedron_scene(), octahedron());
  EXPECT_EQ(sets.mirror->image, (std::vector<std::int32_t>{0, 2, 1, 3, 4, 5, 6}));
  EXPECT_FALSE(sets.mirror->odd);
}

TEST(SymmetricBody, MayBeOffByTheToleranceOfTheScene) {
  Scene scene = octahedron_scene();
  Mesh mesh = octahedron();
  mesh.nodes(1, 1) += 1e-3;
  EXPECT_TRUE(contains(error_of([&] { resolve_selections(scene, mesh); }), "2 nodes have no mirror image"));
  scene.mesh.symmetry->tolerance_m = 2e-3;
  EXPECT_EQ(resolve_selections(scene, mesh).mirror->image[1], 2);
  scene.mesh.symmetry->tolerance_m = 10;  // then a node next to the image may be taken for it, never twice
  EXPECT_EQ(resolve_selections(scene, mesh).mirror->image[1], 2);
}

TEST(SymmetricBody, IsRefusedIfCellsOrSetsAreNot) {
  Scene scene = octahedron_scene();
  Mesh mesh = octahedron();
  mesh.cells.conservativeResize(7, 4);
  mesh.surface = boundary_triangles(mesh.cells);
  auto message = error_of([&] { resolve_selections(scene, mesh); });
  EXPECT_TRUE(contains(message, "1 cell has no mirror image: 6")) << message;

  scene.fixed = parse_selection("{ nodes = [1, 3, 5] }");
  message = error_of([&] { resolve_selections(scene, octahedron()); });
  EXPECT_TRUE(contains(message, "fixed") && contains(message, "node 1 ")) << message;
  scene.fixed = octahedron_scene().fixed;
  for (auto* set : {&scene.active, &scene.output}) {
    Scene lopsided = scene;
    (set == &scene.active ? lopsided.active : lopsided.output) = parse_selection("{ nodes = [2] }");
    message = error_of([&] { resolve_selections(lopsided, octahedron()); });
    EXPECT_TRUE(contains(message, "nodes are not symmetric") && contains(message, "image 1 is not")) << message;
  }
}

/// Two tetrahedra on the side x >= 0 of the plane x = 0, in .msh 2.2: `x` of the node that is off the plane.
std::string half_msh(const std::string& x) {
  return msh_2("1 4 2 7 1 1 2 3 5\n2 4 2 7 1 1 3 4 5\n", 2, "1 0 0 0\n2 0 1 0\n3 0 0 1\n4 0 -1 0\n5 " + x + " 0 0\n");
}

Scene half_scene(const std::filesystem::path& file) {
  Scene scene;
  scene.mesh.file = file;
  scene.mesh.scale_to_m = 0.01;
  SymmetryPlane plane;
  plane.fraction = false;
  plane.point = {0, 0, 0};
  plane.normal = {1, 0, 0};
  plane.half = true;
  scene.mesh.symmetry = plane;
  return scene;
}

TEST(HalfABody, BecomesTheWhole) {
  const TemporaryFile file(half_msh("3"), ".msh");
  const Scene scene = half_scene(file.path);
  const auto made = make_mesh(scene);
  EXPECT_EQ(made.mesh.n_nodes(), 6);
  EXPECT_EQ(made.mesh.n_cells(), 4);
  EXPECT_NEAR(made.quality.volume_m3, 2e-6, 1e-18);  // four times 3 * 1 * 1 / 6 cm3, to rounding
  EXPECT_EQ(made.mesh.nodes.row(5), Eigen::RowVector3d(-0.03, 0, 0));
  EXPECT_EQ(made.mesh.groups.at("7"), (std::vector<std::int32_t>{0, 1, 2, 3, 4, 5}));
  EXPECT_TRUE(contains(joined(made.notes), "5 nodes became 6")) << joined(made.notes);
}

TEST(HalfABody, ThatIsNoneIsRefused) {
  const TemporaryFile apart(half_msh("3"), ".msh");
  Scene scene = half_scene(apart.path);
  scene.mesh.symmetry->point = {-0.02, 0, 0};
  EXPECT_TRUE(contains(error_of([&] { make_mesh(scene); }), "no node lies on the plane"));
  scene.mesh.symmetry->point = {0.01, 0, 0};
  const auto message = error_of([&] { make_mesh(scene); });
  EXPECT_TRUE(contains(message, "1 nodes before the plane, 4 behind it")) << message;
}

}  // namespace
}  // namespace phynness::test
