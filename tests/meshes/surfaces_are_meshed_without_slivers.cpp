// Claim: a remeshed surface with features finer than the edges, with folds or with thin parts is filled without
// slivers, cells of quality below 0.1. Remaining slivers are reported with reason and place, and so is a change of the
// volume. Surfaces without such shapes are not changed.
#include <Eigen/LU>

#include "mesh_under_test.hpp"
#include "read/flat_cells.hpp"

namespace phynness::test {
namespace {

MeshResult remeshed_file(const std::filesystem::path& file, double scale_to_m, double edge_m) {
  Scene scene;
  scene.mesh.file = file;
  scene.mesh.scale_to_m = scale_to_m;
  scene.mesh.target_size_m = edge_m;
  return make_mesh(scene);
}

const std::filesystem::path gallbladder =
    std::filesystem::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes/sofa_env/gallbladder_surface.stl";

/// A box, or with `tip` below 1 a wedge whose upper face is narrower in x.
std::string box_obj(const Eigen::Vector3d& size, double tip = 1) {
  std::string text;
  for (int i = 0; i < 8; ++i)
    text += "v " + std::to_string(size[0] * (i / 2 % 2) * (i / 4 ? tip : 1)) + " " + std::to_string(size[1] * (i % 2)) +
            " " + std::to_string(size[2] * (i / 4)) + "\n";
  return text + "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n";
}

TEST(RemeshedSurfaces, OfAnOrganHaveNoSlivers) {
  SKIP_WITHOUT_GMSH();
  for (const double edge_m : {0.012, 0.01, 0.009, 0.008, 0.006, 0.005}) {
    const MeshResult result = remeshed_file(gallbladder, 0.001, edge_m);
    EXPECT_EQ(result.quality.n_slivers, 0) << edge_m << ": " << result.quality.min_quality;
  }
}

TEST(RemeshedSurfaces, OfThinBodiesHaveNoSlivers) {
  SKIP_WITHOUT_GMSH();
  for (const double edge_m : {0.005, 0.006, 0.007, 0.008, 0.01, 0.012}) {
    const TemporaryFile slab(box_obj({0.12, 0.12, 0.008}), ".obj"), wedge(box_obj({0.03, 0.1, 0.1}, 0.1), ".obj");
    const MeshResult flat = remeshed_file(slab.path, 1, edge_m), sharp = remeshed_file(wedge.path, 1, edge_m);
    EXPECT_EQ(flat.quality.n_slivers, 0) << edge_m << ": " << flat.quality.min_quality;
    EXPECT_NEAR(flat.quality.volume_m3, 0.12 * 0.12 * 0.008, 1e-3 * 0.12 * 0.12 * 0.008);
    EXPECT_EQ(sharp.quality.n_slivers, 0) << edge_m << ": " << sharp.quality.min_quality;
    EXPECT_NEAR(sharp.quality.volume_m3, 0.55 * 3e-4, 0.01 * 0.55 * 3e-4) << edge_m;
  }
}

TEST(RemeshedSurfaces, SayWhyACellIsFlatAndWhatTheEdgesCutOff) {
  SKIP_WITHOUT_GMSH();
  const MeshResult coarse = remeshed_file(gallbladder, 0.001, 0.02);
  EXPECT_TRUE(contains(joined(coarse.warnings), "changed the volume of the body by -")) << joined(coarse.warnings);
  if (coarse.quality.n_slivers > 0) {
    EXPECT_TRUE(contains(joined(coarse.warnings), "smaller mesh.target_size_m or a smoother surface"));
  }
  EXPECT_FALSE(contains(joined(remeshed_file(gallbladder, 0.001, 0.005).warnings), "volume"));
}

double volume_of(const meshes::RawMesh& raw) {
  double sum = 0;
  for (const auto& cell : raw.tetrahedra) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) edges(k, i) = raw.nodes[cell[k + 1]][i] - raw.nodes[cell[0]][i];
    sum += std::abs(edges.determinant()) / 6;
  }
  return sum;
}

TEST(FlatCells, BetweenFacesGetANodeThatCuresThem) {
  // Two crossing edges, 0.02 apart, and a node above and below.
  meshes::RawMesh raw;
  raw.nodes = {{1, 0, 0.01}, {-1, 0, 0.01}, {0, 1, -0.01}, {0, -1, -0.01}, {0, 0, 1}, {0, 0, -1}};
  raw.tetrahedra = {{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 4, 3}, {2, 3, 5, 0}, {2, 3, 1, 5}};
  const double volume = volume_of(raw);
  EXPECT_EQ(meshes::split_slivers(raw), 1);
  EXPECT_EQ(raw.nodes.size(), 7u);
  EXPECT_NEAR(volume_of(raw), volume, 1e-12) << "cells neither overlap nor leave a gap";
  const MeshResult result = [&] {
    std::string text;
    for (std::size_t c = 0; c < raw.tetrahedra.size(); ++c) {
      text += std::to_string(c + 1) + " 4 2 0 1";
      for (const std::int32_t node : raw.tetrahedra[c]) text += " " + std::to_string(node + 1);
      text += "\n";
    }
    std::string nodes;
    for (std::size_t i = 0; i < raw.nodes.size(); ++i) {
      nodes += std::to_string(i + 1);
      for (const double x : raw.nodes[i]) nodes += " " + std::to_string(x);
      nodes += "\n";
    }
    return import_bytes(msh_2(text, static_cast<int>(raw.tetrahedra.size()), nodes, 7), ".msh");
  }();
  EXPECT_GE(result.quality.min_quality, sliver_quality);
  EXPECT_EQ(result.quality.n_surface_triangles, 8);
  EXPECT_EQ(meshes::split_slivers(raw), 0);
}

TEST(FlatCells, AtATipGoWithIt) {
  meshes::RawMesh raw;
  raw.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, -1}, {0.3, 0.3, 0.02}};
  raw.tetrahedra = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  EXPECT_EQ(meshes::peel_slivers(raw), 1);
  EXPECT_EQ(raw.tetrahedra, (std::vector<meshes::Tetrahedron>{{0, 1, 2, 3}}));
}

TEST(FlatCells, StayWhereFlatTrianglesWouldComeToLight) {
  // The swap would make the triangle of nodes 0, 2 and 4, which are nearly on a line.
  meshes::RawMesh raw;
  raw.nodes = {{0, 0, 0}, {1, 1, 0.01}, {2, 0, 0}, {1, -1, -1}, {1, 0.02, 0.02}, {1, 1, -1}};
  raw.tetrahedra = {{0, 1, 2, 4}, {0, 2, 3, 4}, {0, 1, 2, 5}, {0, 2, 3, 5}};
  const auto before = raw.tetrahedra;
  meshes::peel_slivers(raw);
  EXPECT_EQ(raw.tetrahedra, before);
}

}  // namespace
}  // namespace phynness::test
