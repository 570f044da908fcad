// Claims: the liver with the size of the paper has the paper's counts. target_nodes is met. Shapes have the volumes of
// closed forms. The same scene gives the same mesh. Impossible sizes are refused.
#include <cmath>
#include <numbers>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

TEST(BuiltInShapes, LiverAtThePapersSizeHasThePapersCounts) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::liver;
  scene.mesh.target_nodes = 739;
  const MeshResult result = make_mesh(scene);
  const QualityReport& q = result.quality;
  EXPECT_NEAR(q.n_nodes, 739, 0.05 * 739);
  EXPECT_NEAR(q.n_cells, 2341, 0.10 * 2341);
  EXPECT_NEAR(q.n_surface_nodes / static_cast<double>(q.n_nodes), 0.8,
              0.05);  // the paper's body is this flat
  EXPECT_EQ(q.n_slivers, 0);
  // Remeshing cuts the smooth shape's corners by a fraction of the edge length, about 1 cm.
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(q.max_m[k] - q.min_m[k], (std::array{0.20, 0.14, 0.05}[k]), 0.004) << "axis " << k;
  EXPECT_TRUE(contains(joined(result.notes), "wanted 739 nodes, got " + std::to_string(q.n_nodes)));
}

TEST(BuiltInShapes, LiverTapersFromRightToLeft) {
  SKIP_WITHOUT_GMSH();
  const MeshResult result = shape(Shape::liver);
  double right = 0, left = 0;  // volume of cells on either side
  for (Eigen::Index c = 0; c < result.mesh.cells.rows(); ++c) {
    double x = 0;
    for (int k = 0; k < 4; ++k) x += result.mesh.nodes(result.mesh.cells(c, k), 0) / 4;
    (x < 0 ? right : left) += 1;
  }
  EXPECT_GT(right, 1.5 * left);
}

TEST(BuiltInShapes, SameSceneGivesTheSameMesh) {
  SKIP_WITHOUT_GMSH();
  for (const Shape kind : {Shape::liver, Shape::block, Shape::tube})
    EXPECT_EQ(mesh_hash(shape(kind, 300).mesh), mesh_hash(shape(kind, 300).mesh)) << name(kind);
}

TEST(BuiltInShapes, TargetNodesAreMetWithinFivePercent) {
  SKIP_WITHOUT_GMSH();
  for (const Shape kind : {Shape::liver, Shape::block, Shape::cylinder, Shape::tube})
    EXPECT_NEAR(shape(kind, 300).mesh.n_nodes(), 300, 0.05 * 300) << name(kind);
  EXPECT_NEAR(shape(Shape::liver, 1000).mesh.n_nodes(), 1000, 0.05 * 1000);
}

TEST(BuiltInShapes, BlockHasItsVolumeExactly) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::block;
  scene.mesh.size_m = {0.03, 0.02, 0.01};
  scene.mesh.target_size_m = 0.005;
  EXPECT_NEAR(make_mesh(scene).quality.volume_m3, 6e-6, 1e-12 * 6e-6);  // plane faces: only rounding
}

// A circle cut into chords of length h loses the fraction (h / r)^2 / 6 of its area: second order, checked both ways.
TEST(BuiltInShapes, CylinderVolumeConvergesToTheClosedFormInSecondOrder) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::cylinder;
  scene.mesh.radius_m = 0.02;
  scene.mesh.length_m = 0.04;
  const double exact = std::numbers::pi * 0.02 * 0.02 * 0.04;
  double errors[2];
  for (int i = 0; i < 2; ++i) {
    scene.mesh.target_size_m = i == 0 ? 0.008 : 0.004;
    errors[i] = 1 - make_mesh(scene).quality.volume_m3 / exact;
    EXPECT_GT(errors[i], 0);
    EXPECT_LT(errors[i], std::pow(*scene.mesh.target_size_m / 0.02, 2) / 6 * 1.2);
  }
  const double order = std::log2(errors[0] / errors[1]);
  EXPECT_GT(order, 1.5);
  EXPECT_LT(order, 2.5);
}

TEST(BuiltInShapes, TubeIsHollow) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::tube;
  scene.mesh.radius_m = 0.010;
  scene.mesh.inner_radius_m = 0.006;
  scene.mesh.length_m = 0.03;
  scene.mesh.target_size_m = 0.002;
  const MeshResult result = make_mesh(scene);
  const double exact = std::numbers::pi * (1e-4 - 3.6e-5) * 0.03;
  EXPECT_NEAR(result.quality.volume_m3, exact, 0.03 * exact);
  EXPECT_EQ(result.quality.n_surface_triangles, 2 * result.quality.n_surface_nodes);  // Euler: one handle
}

TEST(BuiltInShapes, ImpossibleWishesAreRefused) {
  Scene scene;
  scene.mesh.shape = Shape::tube;
  scene.mesh.where = {"scene.toml", 3};
  scene.mesh.target_size_m = 1e-6;
  expect_names(error_of([&] { make_mesh(scene); }), {"scene.toml:3", "1e-06 m"});
  scene.mesh.target_size_m = 14;  // millimetres
  expect_names(error_of([&] { make_mesh(scene); }), {"scene.toml:3", "14 m", "too large for the body", "in metres"});
}

}  // namespace
}  // namespace phynness::test
