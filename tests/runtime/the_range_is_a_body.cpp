// Claims about the trained range: every trained displacement is inside; the depth is that of formats/model.md, Range,
// and nowhere more than the depth of the nearest direction; the warning begins at this depth.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// 26 directions, two increments to 0.01 m. The depths of node 3 are all different, some are 0; node 5 has one short
/// ray, in direction 7.
Model uneven_model() {
  Model model = small_modal_model();
  model.directions = exploratory_directions(Directions::twenty_six);
  model.displacements.resize(52, 3);
  for (int i = 0; i < 52; ++i)
    for (int k = 0; k < 3; ++k)
      model.displacements(i, k) = 0.005 * (i % 2 + 1) * model.directions[static_cast<std::size_t>(i / 2)][k];
  Numbers numbers;
  for (auto& node : model.nodes) node.trained_depth_m.assign(26, 0.01);
  for (double& depth : model.nodes[0].trained_depth_m) depth = 0.01 * std::fmax(0.0, numbers.next());
  model.nodes[1].trained_depth_m[7] = 0.002;
  return model;
}

double depth_at(const LoadedModel& loaded, std::int32_t node, const Eigen::Vector3d& d) {
  return Trained(loaded.model, node, d.data()).depth;
}

Eigen::Vector3d direction(const Model& model, std::size_t i) {
  return {model.directions[i][0], model.directions[i][1], model.directions[i][2]};
}

TEST(Range, HoldsEveryTrainedDisplacement) {
  const Model model = uneven_model();
  const LoadedModel loaded(write_model_text(model));
  for (const std::size_t n : {0, 1, 2}) {
    const auto& node = model.nodes[n];
    for (std::size_t i = 0; i < 26; ++i) {
      const double z = node.trained_depth_m[i];
      for (const double size : {1e-300, 1e-3, 1.0, 1e200}) {
        // 1e-15: rounding of the products that find the nearest direction.
        EXPECT_NEAR(depth_at(loaded, node.node, size * direction(model, i)), z, 1e-15) << node.node << " " << i;
      }
      const Eigen::Vector3d d = z * direction(model, i);
      EXPECT_EQ(Trained(loaded.model, node.node, d.data()).status, PHN_OK);
    }
  }
}

TEST(Range, IsNowhereDeeperThanTheNearestDirectionAndWarnsFromThereOn) {
  const Model model = uneven_model();
  const LoadedModel loaded(write_model_text(model));
  Numbers numbers;
  int shorter = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d e = numbers.vector().normalized();
    for (const std::size_t n : {0, 1}) {
      const auto& node = model.nodes[n];
      std::size_t nearest = 0;
      for (std::size_t k = 1; k < 26; ++k)
        if (e.dot(direction(model, k)) > e.dot(direction(model, nearest))) nearest = k;
      // The definition, with no regard to speed.
      double expected = node.trained_depth_m[nearest];
      const double best = e.dot(direction(model, nearest));
      for (std::size_t k = 0; k < 26; ++k) {
        const double along = e.dot(direction(model, k));
        expected = std::fmin(expected, node.trained_depth_m[k] + 0.02 * (best - along) / (1 - along));
      }
      const double depth = depth_at(loaded, node.node, e);
      EXPECT_NEAR(depth, expected, 1e-14);
      EXPECT_LE(depth, node.trained_depth_m[nearest]);
      shorter += depth < 0.999 * node.trained_depth_m[nearest] ? 1 : 0;
      const Eigen::Vector3d in = 0.999999 * depth * e, out = (1.000001 * depth + 1e-12) * e;
      EXPECT_EQ(Trained(loaded.model, node.node, in.data()).status, PHN_OK);
      EXPECT_EQ(Trained(loaded.model, node.node, out.data()).status, PHN_WARNING_OUTSIDE);
    }
  }
  EXPECT_GT(shorter, 200);
}

}  // namespace
