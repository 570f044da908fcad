// Claim: a refined mesh is the same body with the same nodes first, half the edge length, and cells of similar quality.
// Sets of nodes also contain the midpoints of edges between their nodes. Volumes and areas agree up to rounding.
#include <algorithm>
#include <set>

#include "../block_mesh.hpp"
#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

/// Triangles with the smallest node first, in their orientation.
std::set<std::array<std::int32_t, 3>> triangles_of(const Triangles& triangles) {
  std::set<std::array<std::int32_t, 3>> all;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    std::array<std::int32_t, 3> one{triangles(t, 0), triangles(t, 1), triangles(t, 2)};
    std::rotate(one.begin(), std::min_element(one.begin(), one.end()), one.end());
    all.insert(one);
  }
  return all;
}

void expect_refined(const Mesh& coarse) {
  const auto edges = mesh_edges(coarse);
  const Mesh fine = refined(coarse);
  ASSERT_EQ(fine.n_nodes(), coarse.n_nodes() + static_cast<std::int32_t>(edges.size()));
  EXPECT_EQ(fine.n_cells(), (coarse.cells.cols() == 4 ? 8 : 4) * coarse.n_cells());
  EXPECT_EQ(fine.nodes.topRows(coarse.n_nodes()), coarse.nodes);
  const auto before = measure_quality(coarse), after = measure_quality(fine);
  EXPECT_NEAR(after.volume_m3, before.volume_m3, 1e-12 * before.volume_m3);
  EXPECT_NEAR(after.area_m2, before.area_m2, 1e-12 * before.area_m2);
  EXPECT_NEAR(after.max_edge_m, before.max_edge_m / 2, 0.5 * before.max_edge_m / 2);
  EXPECT_GT(after.min_quality, 0.3 * before.min_quality);
  if (coarse.cells.cols() == 4) {
    EXPECT_EQ(triangles_of(fine.surface), triangles_of(boundary_triangles(fine.cells)));
  }
}

TEST(Refined, tetrahedra_are_the_same_body) {
  for (const char* file : {"own/liver_coarse.msh", "sofa_env/tissue_slab.msh"})
    expect_refined(import_file(std::string(PHYNNESS_SOURCE_DIR) + "/tests/data/meshes/" + file).mesh);
}

TEST(Refined, triangles_of_a_shell_are_the_same_surface) {
  SKIP_WITHOUT_GMSH();
  Scene scene;
  scene.mesh.shape = Shape::drain;
  scene.mesh.thickness_m = 0.0005;
  expect_refined(make_mesh(scene).mesh);
}

// Claim: below a node of the surface so many cells lie across the body as its thickness there has mean edges. In a
// block of 6 x 4 x 2 boxes the ways from a node of the middle of each side are 6, 4 and 2 boxes, up to rounding.
TEST(CellsAcross, are_the_thickness_in_mean_edges) {
  const Mesh block = block_mesh({6, 4, 2}, {0.06, 0.04, 0.02});
  const auto number = [](int i, int j, int k) { return (k * 5 + j) * 7 + i; };
  const std::int32_t top = number(3, 2, 2), end = number(6, 2, 1), side = number(3, 4, 1);
  const double edge_m = measure_quality(block).mean_edge_m;
  const auto across = cells_across(block, {top, end, side});
  EXPECT_NEAR(across.least * edge_m, 0.02, 1e-12);
  EXPECT_EQ(across.thinnest, top);
  EXPECT_NEAR(across.median * edge_m, 0.04, 1e-12);
  EXPECT_EQ(cells_across(block, {}).thinnest, -1);
}

TEST(Refined, sets_grow_by_the_middles_of_their_edges) {
  const auto mesh = import_bytes(msh_2(two_cells, 2), ".msh").mesh;
  const auto edges = mesh_edges(mesh);
  ASSERT_EQ(edges.size(), 9u);  // all pairs of five nodes but the two tips
  const auto set = refined({0, 1, 2}, edges, mesh.n_nodes());
  ASSERT_EQ(set.size(), 6u);
  const Mesh fine = refined(mesh);
  for (const auto node : set) EXPECT_EQ(fine.nodes(node, 2), 0) << node;
}

}  // namespace
}  // namespace phynness::test
