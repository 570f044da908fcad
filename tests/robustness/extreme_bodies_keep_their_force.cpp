// Claims about bodies at extreme parameters (docs/extremes.md):
// - For K/mu above 1000 the force of mixed elements hardly depends on K/mu, while that of P1 depends mainly on it.
// - Cells flattened to a billionth of their height do not prevent convergence, and the force changes as for any other
// motion
//   of a node.
// - A round tool may slide farther than its radius.
#include <gtest/gtest.h>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

constexpr double push_m = 0.006;

/// A patch of two edges: the force at a node has no limit under refinement.
ProbeBlock pressed(Element element, double bulk_to_shear, Law law = law_named("neo-hookean")) {
  auto block = probe_block({law, element}, bulk_to_shear, {6, 4, 4});
  block.scene.probe.kind = ProbeKind::patch;
  block.scene.probe.tool_radius_m = 0.03;
  return block;
}

/// Of the push by `depth_m`, along it.
double push_N(const ProbeBlock& block) {
  const auto r = block.touched().solve({{0, 0, -push_m}}, 2);
  EXPECT_EQ(r.status, Status::converged);
  EXPECT_GT(r.min_jacobian, 0);
  return -r.force_N[0][2];
}

class Incompressible : public ::testing::TestWithParam<Case> {};

TEST_P(Incompressible, ForceHasALimit) {
  // J - 1 is of the size of mu/K: 1e-3 of the force is what is left of it from 1000 on; thrice that for the
  // strains at the tool's rim.
  const double at_1e3 = push_N(pressed(GetParam().element, 1e3, GetParam().law)),
               at_1e5 = push_N(pressed(GetParam().element, 1e5, GetParam().law));
  EXPECT_GT(at_1e3, 0.1);
  EXPECT_NEAR(at_1e5, at_1e3, 3e-3 * at_1e3);
  // Case 4's ratio lies between.
  const double case_4 = push_N(pressed(GetParam().element, 100e3 / 4.4, GetParam().law));
  EXPECT_GE(case_4, std::min(at_1e3, at_1e5));
  EXPECT_LE(case_4, std::max(at_1e3, at_1e5));
}

INSTANTIATE_TEST_SUITE_P(Mixed, Incompressible,
                         ::testing::ValuesIn(cases({{"neo-hookean", {"p1-p1", "es-p1-p1", "taylor-hood"}},
                                                    {"mooney-rivlin", {"p1-p1", "es-p1-p1", "taylor-hood"}}})),
                         case_name);

TEST(LockedP1, FeelsTheBulkModulusInstead) {
  // Locked, the stiffness follows K: two decades apart it grows at least threefold (measured: 3.9), in a body whose own
  // grows by 0.1 %. At rest, as the locked body does not even converge to this depth at 1e5. The mesh is irregular,
  // because regular cells have motions without a change of volume.
  const auto stiffness = [](double ratio) {
    auto block = pressed(element_named("P1"), ratio);
    Random random(7);
    block.mesh = irregular(block.mesh, 0.003, random);
    return block.touched().rest().stiffness_N_per_m(2, 2);
  };
  EXPECT_GT(stiffness(1e5), 3 * stiffness(1e3));
}

class FlatCells : public ::testing::TestWithParam<Element> {};

TEST_P(FlatCells, CostNoConvergence) {
  // One inner node goes all but a thousandth or a billionth of the way to the plane of the other corners of
  // one of its cells. Both are the same body to a thousandth of the way, 0.015 mm of 60: 1 % of the force,
  // the locked element's included.
  auto block = pressed(GetParam(), 200);
  const double good = push_N(block);
  const auto node = nearest_node(block.mesh, {0.05, 0.04, 0.03});
  const Eigen::RowVector3d start = block.mesh.nodes.row(node);
  const auto flattened = [&](double left) {
    block.mesh.nodes.row(node) = start - (1 - left) * Eigen::RowVector3d(0, 0, 0.015);
    double flattest = 1;
    for (Eigen::Index c = 0; c < block.mesh.cells.rows(); ++c) {
      Eigen::Matrix3d edges;
      for (int k = 0; k < 3; ++k)
        edges.row(k) = block.mesh.nodes.row(block.mesh.cells(c, k + 1)) - block.mesh.nodes.row(block.mesh.cells(c, 0));
      flattest = std::min(flattest, edges.determinant() / (0.1 / 6 * 0.02 * 0.015));
    }
    EXPECT_GT(flattest, 0);
    EXPECT_LT(flattest, 1.01 * left);
    return push_N(block);
  };
  const double bad = flattened(1e-3), worse = flattened(1e-9);
  EXPECT_NEAR(worse, bad, 0.01 * bad);
  // The move itself changes the mesh under the tool: a tenth, where nothing locks.
  if (GetParam() != element_named("P1")) {
    EXPECT_NEAR(worse, good, 0.1 * good);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, FlatCells, ::testing::ValuesIn(every_element), element_name);

class SlidFar : public ::testing::TestWithParam<Element> {};

TEST_P(SlidFar, IsFollowed) {
  // 1.3 radii sideways. A rigid patch would fold the surface over itself from 0.65 radii on.
  const auto block = pressed(GetParam(), 200);
  const double r = block.scene.probe.tool_radius_m;
  auto solver = block.touched();
  const auto near = solver.solve({{0.3 * r, 0, 0}}, 4), far = solver.solve({{1.3 * r, 0, 0}}, 8);
  EXPECT_EQ(near.status, Status::converged);
  EXPECT_EQ(far.status, Status::converged);
  EXPECT_GT(far.min_jacobian, 0.03);
  EXPECT_GT(far.force_N[0][0], near.force_N[0][0]);
}

INSTANTIATE_TEST_SUITE_P(Elements, SlidFar, ::testing::ValuesIn(every_element), element_name);

}  // namespace
}  // namespace phynness::test
