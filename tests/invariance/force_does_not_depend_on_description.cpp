// Claim: the force of a probe does not depend on the description of the body: if the scene is rotated, in other units,
// renumbered or far from the origin, the force is the same.
//
// The solver's tolerance is 1e-11 of the reactions, and the error of a force is this times the norm of the
// sensitivities (about 1e1): two solves of the same problem agree to 1e-9. If the iterates are the same, the difference
// is smaller.
#include <gtest/gtest.h>

#include <numeric>

#include "probe_block.hpp"

namespace phynness::test {
namespace {

using Vector3 = Eigen::Vector3d;

constexpr double tolerance = 1e-9;
const Vec3 displacement{0.004, 0.003, -0.006};

class SameScene : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    _block = probe_block(GetParam(), 10, {4, 4, 3});
    _block.mesh = irregular(std::move(_block.mesh), 0.004, _random);
    _block.scene.solver.relative_tolerance = 1e-11;
    _block.scene.probe.kind = ProbeKind::patch;
    // Just what the nodes are apart in x: those on the rim must stay free, however their distance is rounded.
    _block.scene.probe.tool_radius_m = 0.025;
    _force = force(_block, displacement);
    ASSERT_GT(_force.norm(), 0.01);
  }

  static Vector3 force(const ProbeBlock& block, const Vec3& d) {
    const auto response = block.touched().solve({d}, 3);
    EXPECT_EQ(response.status, Status::converged);
    return {response.force_N[0][0], response.force_N[0][1], response.force_N[0][2]};
  }

  Random _random{53};
  ProbeBlock _block;
  Vector3 _force;
};

TEST_P(SameScene, TurnedGivesTheTurnedForce) {
  // Isotropy and objectivity together; the linear law has the one, and no need of the other, as nothing turns
  // relative to the reference configuration.
  const Eigen::Matrix3d R = Eigen::AngleAxisd(2.2, Vector3(0.3, 1, -0.7).normalized()).toRotationMatrix();
  auto turned = _block;
  turned.mesh.nodes = _block.mesh.nodes * R.transpose();
  const Vector3 d = R * Vector3(displacement[0], displacement[1], displacement[2]);
  EXPECT_LT((force(turned, {d[0], d[1], d[2]}) - R * _force).norm(), tolerance * _force.norm());
}

TEST_P(SameScene, InMillimetresAndOtherModuliGivesTheSameDimensionlessForce) {
  auto scaled = _block;
  scaled.mesh.nodes *= 1e3;
  scaled.scene.probe.tool_radius_m *= 1e3;
  scaled.scene.material = times(1e6, scaled.scene.material);
  const auto f = force(scaled, {1e3 * displacement[0], 1e3 * displacement[1], 1e3 * displacement[2]});
  EXPECT_LT((f / 1e12 - _force).norm(), 1e-10 * _force.norm());
}

TEST_P(SameScene, RenumberedGivesTheSameForce) {
  const auto n = static_cast<std::size_t>(_block.mesh.n_nodes());
  std::vector<std::int32_t> number(n);  // old -> new
  std::iota(number.begin(), number.end(), 0);
  for (std::size_t i = n - 1; i > 0; --i) std::swap(number[i], number[_random.below(i + 1)]);

  auto renumbered = _block;
  for (std::size_t i = 0; i < n; ++i) renumbered.mesh.nodes.row(number[i]) = _block.mesh.nodes.row(i);
  for (Eigen::Index c = 0; c < _block.mesh.cells.rows(); ++c) {
    // Cells in reverse order, and each begun at another vertex: an even permutation keeps the orientation.
    const Eigen::Index from = _block.mesh.cells.rows() - 1 - c;
    constexpr int even[4] = {1, 2, 0, 3};
    for (int i = 0; i < 4; ++i) renumbered.mesh.cells(c, i) = number[_block.mesh.cells(from, even[i])];
  }
  renumbered.mesh.surface = boundary_triangles(renumbered.mesh.cells);
  for (auto& node : renumbered.sets.fixed) node = number[node];
  std::sort(renumbered.sets.fixed.begin(), renumbered.sets.fixed.end());
  renumbered.top = number[_block.top];
  EXPECT_LT((force(renumbered, displacement) - _force).norm(), tolerance * _force.norm());
}

TEST_P(SameScene, AThousandBodySizesAwayLosesThreeDigits) {
  // Coordinates of 1e3 body sizes carry an error of 1e-13, so element edges one of 1e-12 relative, and every
  // entry of the residual with them.
  auto moved = _block;
  moved.mesh.nodes.rowwise() += Eigen::RowVector3d(60, -70, 80);
  moved.scene.solver.relative_tolerance = 1e-10;
  EXPECT_LT((force(moved, displacement) - _force).norm(), tolerance * _force.norm());
}

INSTANTIATE_TEST_SUITE_P(Laws, SameScene,
                         ::testing::ValuesIn(cases({{"neo-hookean", {"P1", "P2", "taylor-hood", "p1-p1", "es-p1-p1"}},
                                                    {"st-venant-kirchhoff", {"P1"}},
                                                    {"mooney-rivlin", {"p1-p1", "es-p1-p1"}},
                                                    {"linear", {"p1-p1", "es-p1-p1"}}})),
                         case_name);

}  // namespace
}  // namespace phynness::test
