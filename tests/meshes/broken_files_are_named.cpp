// Claim: defective files are refused with the defect and its count, or repaired with a note. The counts are those that
// tests/data/meshes/make.py makes.
#include "mesh_under_test.hpp"

namespace phynness::test {
namespace {

std::filesystem::path broken(const char* name) {
  return std::filesystem::path(PHYNNESS_SOURCE_DIR) / "tests/data/meshes/broken" / name;
}

TEST(BrokenFiles, NonManifoldSurfaceNamesEdgesAndPinchedVertex) {
  const auto file = broken("non_manifold_liver.stl");
  const std::string message = error_of([&] { import_file(file); });
  EXPECT_TRUE(contains(message, "8 non-manifold edges")) << message;
  EXPECT_TRUE(contains(message, "1 pinched vertex")) << message;
}

TEST(BrokenFiles, RepairKeepsTheLargestComponentAndTurnsItByName) {
  SKIP_WITHOUT_GMSH();
  const auto file = broken("inward_normals_four_components.vtk");
  const MeshResult result = import_file(file, 0.001, true);
  const std::string notes = joined(result.notes);
  EXPECT_TRUE(contains(notes, "kept the largest of 4 components")) << notes;
  EXPECT_TRUE(contains(notes, "inward")) << notes;
  EXPECT_GT(result.quality.volume_m3, 0);
}

TEST(BrokenFiles, SliversAreAWarningWithNumberAndQuality) {
  const auto file = broken("sliver_liver.vtk");
  const MeshResult result = import_file(file, 0.001);
  EXPECT_EQ(result.quality.n_cells, 1575);
  EXPECT_GT(result.quality.n_slivers, 0);
  expect_names(joined(result.warnings), {std::to_string(result.quality.n_slivers) + " slivers, worst quality"});
}

}  // namespace
}  // namespace phynness::test
