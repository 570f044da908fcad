// Claim: calibration and validation whose sizes the scene does not give solve together at most half as many increments
// as the database has, whatever its directions and increments, unless it has too few for bounds; large databases have
// no larger ones. Of tools between nodes none are counted where no triangle has three active corners. A given size is
// kept, and the other one takes what is left.
#include <gtest/gtest.h>

#include <phynness/validation/sizes.hpp>

#include "block_mesh.hpp"

namespace phynness::test {
namespace {

struct Study {
  Scene scene;
  DatabaseHeader header;
  double increments = 0;
};

Study study(int n_active, Directions directions, int increments) {
  Study study;
  const auto mesh = block_mesh({6, 6, 2}, {0.1, 0.08, 0.06});
  study.scene.probe.directions = directions;
  study.scene.probe.increments = increments;
  // The top is flat, so that from its middle 17 of 26 directions lead into the body or along it.
  Eigen::Index middle = 0;
  (mesh.nodes.rowwise() - Eigen::RowVector3d(0.05, 0.04, 0.06)).rowwise().squaredNorm().minCoeff(&middle);
  NodeSets sets;
  sets.active.assign(static_cast<std::size_t>(n_active), static_cast<std::int32_t>(middle));
  study.header = database_header(study.scene, mesh, sets);
  study.increments = n_active * increments * (directions == Directions::hemisphere ? 17.0 : 26.0);
  return study;
}

TEST(Checks, solve_together_half_of_the_increments) {
  for (const auto directions : {Directions::twenty_six, Directions::hemisphere})
    for (const int n_active : {16, 47, 60})
      for (const int increments : {4, 6, 8}) {
        const auto s = study(n_active, directions, increments);
        const auto sizes = sizes_of_checks(s.scene, s.header, true);
        const double all = sizes.calibration_increments + sizes.validation_increments;
        const bool least = sizes.calibration_rays == 100 || sizes.probes == 50;
        if (!least) {
          EXPECT_LE(all, 0.5 * s.increments) << n_active << " " << increments;
        }
        if (!least && sizes.probes < 200) {
          EXPECT_GE(all, 0.45 * s.increments) << n_active << " " << increments;
        }
        EXPECT_GE(sizes.calibration_rays, 100);
        EXPECT_GE(sizes.probes, 50);
      }
}

TEST(Checks, have_limits_and_take_what_is_left) {
  auto large = study(400, Directions::twenty_six, 6);
  auto sizes = sizes_of_checks(large.scene, large.header, true);
  EXPECT_EQ(sizes.calibration_rays, 1000);
  EXPECT_EQ(sizes.probes, 200);
  EXPECT_EQ(sizes.calibration_increments, 3 * 1000);
  large.header.sets.active.clear();
  for (Eigen::Index k = 0; k < 3; ++k) large.header.sets.active.push_back(large.header.mesh.surface(0, k));
  std::ranges::sort(large.header.sets.active);
  large.scene.validation.calibration_rays = 1000;
  EXPECT_EQ(sizes_of_checks(large.scene, large.header, true).calibration_increments, 3 * 1000 + 3 * 150);
  auto s = study(20, Directions::twenty_six, 6);  // 3,120 increments
  sizes = sizes_of_checks(s.scene, s.header, true);
  s.scene.validation.calibration_rays = sizes.calibration_rays + 100;
  const auto given = sizes_of_checks(s.scene, s.header, true);
  EXPECT_EQ(given.calibration_rays, sizes.calibration_rays + 100);
  EXPECT_LT(given.probes, sizes.probes);
  s.scene.validation.probes = 500;
  EXPECT_EQ(sizes_of_checks(s.scene, s.header, true).probes, 500);
  s.scene.validation = {};
  const auto unbounded = sizes_of_checks(s.scene, s.header, false);
  EXPECT_EQ(unbounded.calibration_rays, 0);
  EXPECT_GT(unbounded.probes, sizes.probes);
}

}  // namespace
}  // namespace phynness::test
