// Claim: a body one kilometre away has the same model: identical in family modal, which uses displacements only, and up
// to rounding for the paper's networks, whose inputs are coordinates.
#include <gtest/gtest.h>

#include "small_responses.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

Model trained(const Eigen::RowVector3d& away, Family family) {
  const DatabaseHeader here = small_header(8);
  DatabaseHeader there = here;
  there.mesh.nodes.rowwise() += away;
  TrainingSpec spec = family == Family::modal ? modal_spec() : small_spec();
  TrainingReport report;
  return train({&there, [&](std::int32_t active) { return small_rays(here, active); }, {}, "away"}, spec, report);
}

const Eigen::RowVector3d kilometre(1000, -1000, 1000);

TEST(BodyFarAway, HasTheSameModalModel) {
  const Model here = trained({0, 0, 0}, Family::modal), there = trained(kilometre, Family::modal);
  ASSERT_EQ(here.nodes.size(), there.nodes.size());
  EXPECT_EQ(here.shared.modes.entries, there.shared.modes.entries);
  for (std::size_t a = 0; a < here.nodes.size(); ++a) {
    EXPECT_EQ(here.nodes[a].conservative.coefficients, there.nodes[a].conservative.coefficients);
    EXPECT_EQ(here.nodes[a].modal.weights.entries, there.nodes[a].modal.weights.entries);
    EXPECT_EQ(here.nodes[a].modal.near_modes.entries, there.nodes[a].modal.near_modes.entries);
  }
}

TEST(BodyFarAway, HasTheSameNetworks) {
  // Coordinates of 1000 m are rounded to 1e-13 m, scaled ones over the body's 0.05 m to 2e-12; the weights of
  // these networks cancel some hundredfold.
  const Model here = trained({0, 0, 0}, Family::rbfn), there = trained(kilometre, Family::rbfn);
  double largest = 0, difference = 0;
  for (std::size_t a = 0; a < here.nodes.size(); ++a)
    for (Eigen::Index row = 0; row < here.displacements.rows(); row += 7)
      for (Eigen::Index o = 0; o < here.output_points.rows(); o += 5) {
        Eigen::VectorXd x(6), y(6);
        x << 0.7 * here.displacements.row(row).transpose(), here.output_points.row(o).transpose();
        y << 0.7 * here.displacements.row(row).transpose(), there.output_points.row(o).transpose();
        const Eigen::Vector3d u = evaluate(here.nodes[a].deformation, x), v = evaluate(there.nodes[a].deformation, y);
        largest = std::max(largest, u.norm());
        difference = std::max(difference, (u - v).norm());
      }
  EXPECT_GT(largest, 0.001);
  EXPECT_LT(difference, 1e-9 * largest);
}

}  // namespace
