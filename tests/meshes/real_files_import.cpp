// Claim: meshes from other programs, in other units and formats, import with the counts their makers state.
#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

std::filesystem::path real(const std::string& name) {
  return std::filesystem::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes" / name;
}

struct Expected {
  const char* file;
  double scale_to_m;
  int nodes, cells;
};

class RealMeshes : public ::testing::TestWithParam<Expected> {};

TEST_P(RealMeshes, ImportWithTheirCounts) {
  const Expected& expected = GetParam();
  const MeshResult result = import_file(real(expected.file), expected.scale_to_m);
  EXPECT_EQ(result.quality.n_nodes, expected.nodes);
  EXPECT_EQ(result.quality.n_cells, expected.cells);
  EXPECT_GT(result.quality.min_quality, 0);
  EXPECT_FALSE(contains(joined(result.warnings), "scale_to_m")) << joined(result.warnings);
}

INSTANTIATE_TEST_SUITE_P(Files, RealMeshes,
                         ::testing::Values(Expected{"own/liver_coarse.msh", 0.025, 180, 462},
                                           Expected{"own/liver_elements.msh", 0.1, 498, 1575},
                                           Expected{"sofa_env/tissue_slab.msh", 1, 493, 1432},
                                           Expected{"own/cylinder.msh", 0.1, 499, 1842}),
                         [](const auto& info) {
                           const std::string file = info.param.file;
                           return file.substr(file.find('/') + 1, file.find('.') - file.find('/') - 1);
                         });

class RealSurfaces : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(RealSurfaces, AreFilledAtTheWantedSize) {
  SKIP_WITHOUT_GMSH();
  const auto [file, scale] = GetParam();
  Scene scene;
  scene.mesh.file = real(file);
  scene.mesh.scale_to_m = scale;
  for (const double edge_m : {0.006, 0.01}) {
    scene.mesh.target_size_m = edge_m;
    const MeshResult result = make_mesh(scene);
    // Inner edges of tetrahedra are longer than those of the surface: the mean of all lies somewhat above the target.
    EXPECT_GT(result.quality.mean_edge_m, 0.9 * edge_m);
    EXPECT_LT(result.quality.mean_edge_m, 1.4 * edge_m);
    EXPECT_FALSE(contains(joined(result.warnings), "remeshing failed")) << joined(result.warnings);
  }
}

TEST_P(RealSurfaces, AreFilledAsTheyAreWithoutATarget) {
  SKIP_WITHOUT_GMSH();
  const auto [file, scale] = GetParam();
  const MeshResult result = import_file(real(file), scale);
  EXPECT_GT(result.quality.volume_m3, 0);
}

INSTANTIATE_TEST_SUITE_P(Files, RealSurfaces,
                         ::testing::Values(std::pair("own/liver_surface.obj", 0.01),
                                           std::pair("sofa_env/gallbladder_surface.stl", 0.001)),
                         [](const auto& info) {
                           const std::string file = info.param.first;
                           return file.substr(file.find('/') + 1, file.find("_surface") - file.find('/') - 1);
                         });

}  // namespace
}  // namespace phynness::test
