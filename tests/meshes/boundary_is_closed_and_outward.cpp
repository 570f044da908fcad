// Claim: boundary triangles of a body form a closed surface with outward normals. The area vectors of a
// closed surface sum to zero and the divergence theorem gives the body's volume; both up to rounding of some
// thousand additions (1e-12).
#include <Eigen/Geometry>

#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

void expect_closed_and_outward(const Mesh& mesh, double volume_m3) {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double area = 0, volume = 0;
  for (Eigen::Index t = 0; t < mesh.surface.rows(); ++t) {
    const Eigen::RowVector3d a = mesh.nodes.row(mesh.surface(t, 0)), b = mesh.nodes.row(mesh.surface(t, 1)),
                             c = mesh.nodes.row(mesh.surface(t, 2));
    const Eigen::RowVector3d vector = (b - a).cross(c - a) / 2;
    sum += vector;
    area += vector.norm();
    volume += vector.dot(a + b + c) / 9;
  }
  EXPECT_LT(sum.norm(), 1e-12 * area);
  EXPECT_NEAR(volume, volume_m3, 1e-12 * volume_m3);
}

TEST(BoundaryTriangles, OfTwoTetrahedraLeaveOutTheCommonFace) {
  const MeshResult result = import_bytes(msh_2(two_cells, 2), ".msh");
  ASSERT_EQ(result.mesh.surface.rows(), 6);
  expect_closed_and_outward(result.mesh,
                            1.0 / 6 + 1.0 / 3);  // corner tetrahedron and the one on its long face
}

TEST(BoundaryTriangles, OfTheLiverAreClosedAndOutward) {
  SKIP_WITHOUT_GMSH();
  const MeshResult result = shape(Shape::liver);
  expect_closed_and_outward(result.mesh, result.quality.volume_m3);
  // Euler: a closed surface without handles has two triangles less than twice its nodes, twice.
  EXPECT_EQ(result.quality.n_surface_triangles, 2 * result.quality.n_surface_nodes - 4);
}

TEST(NodeNormals, PointOutwardOnAConvexBodyAndVanishInside) {
  SKIP_WITHOUT_GMSH();
  const Mesh mesh = shape(Shape::block, 400).mesh;
  const Points normals = node_normals(mesh);
  const Eigen::RowVector3d center = mesh.nodes.colwise().mean();
  const auto on_surface = surface_nodes(mesh.surface);
  std::vector<char> is_surface(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (const auto i : on_surface) is_surface[i] = 1;
  for (Eigen::Index i = 0; i < normals.rows(); ++i) {
    EXPECT_NEAR(normals.row(i).norm(), is_surface[i] ? 1 : 0, 1e-12);
    if (is_surface[i]) {
      EXPECT_GT(normals.row(i).dot(mesh.nodes.row(i) - center), 0);
    }
  }
}

}  // namespace
}  // namespace phynness::test
