#include <gtest/gtest.h>

#include <phynness/training/network_fit.hpp>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

/// Largest value that the terms of an output can reach: what rounding is measured against.
double scale_of(const RbfNetwork& net) {
  return net.output_half_range.maxCoeff() * (net.weights.cwiseAbs().sum() + net.bias.cwiseAbs().sum()) +
         net.output_center.norm();
}

const Eigen::Vector3d network_probes[] = {{0, 0, 0},  {0.004, -0.002, 0.001}, {0.01, 0, 0}, {-0.02, 0.03, 0.01},
                                          {1, 1, -1}, {0, 0.005, 0}};

// Claim: force is (11)-(12) with the recorded transforms, to rounding (1e-14 of the sum of the terms' sizes).
TEST(Runtime, ForceIsTheNetwork) {
  const Model model = small_model();
  const LoadedModel loaded(write_model_text(model));
  for (const ActiveNodeModel& node : model.nodes)
    for (const Eigen::Vector3d& d : network_probes) {
      Eigen::Vector3d force;
      ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force.data(), nullptr, nullptr), 0);
      EXPECT_LT((force - evaluate(node.force, d)).norm(), 1e-14 * scale_of(node.force));
    }
}

// Claim: deformation is (11)-(12) of displacement and coordinates at every output node that the probe does not move;
// those it moves take their weight times the displacement, so the touched node follows exactly. 1e-14 as above.
TEST(Runtime, DeformationIsTheNetwork) {
  const Model model = small_model();
  const LoadedModel loaded(write_model_text(model));
  for (const ActiveNodeModel& node : model.nodes)
    for (const Eigen::Vector3d& d : network_probes) {
      Points u(model.output_points.rows(), 3);
      ASSERT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d.data()), u.data()), 0);
      for (std::size_t o = 0; o < model.output.size(); ++o) {
        const auto row = static_cast<Eigen::Index>(o);
        Eigen::VectorXd inputs(6);
        inputs << d, model.output_points.row(row).transpose();
        Eigen::Vector3d expected = evaluate(node.deformation, inputs);
        for (std::size_t i = 0; i < node.prescribed.size(); ++i)
          if (node.prescribed[i] == model.output[o]) expected = node.prescribed_weight[i] * d;
        EXPECT_LT((u.row(row).transpose() - expected).norm(), 1e-14 * scale_of(node.deformation));
        if (model.output[o] == node.node) {
          EXPECT_EQ(u.row(row).transpose(), d);
        }
      }
    }
}

// Claim: the lists and sizes are the model's.
TEST(Runtime, ListsAreTheModels) {
  const Model model = small_model();
  const LoadedModel loaded(write_model_text(model));
  EXPECT_EQ(info_of(loaded.model).n_nodes, 20);
  ASSERT_EQ(info_of(loaded.model).n_active, 4);
  ASSERT_EQ(info_of(loaded.model).n_output, 12);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(info_of(loaded.model).active_nodes[i], model.nodes[i].node);
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(info_of(loaded.model).output_nodes[i], model.output[i]);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(info_of(loaded.model).output_points[3 * i + k], model.output_points(i, k));
  }
}

// Claim: the depth is that of the nearest direction, beyond it calls warn, and a node with a direction that
// stopped short says so. Outputs are defined all the same.
TEST(Runtime, WarnsBeyondTheTrainedDepth) {
  const LoadedModel loaded(write_model_text(small_model()));
  Eigen::Vector3d d(0.002, 0.0049, 0), force;
  const Trained beyond(loaded.model, 5, d.data());
  EXPECT_EQ(beyond.status, PHN_WARNING_OUTSIDE);
  EXPECT_EQ(beyond.depth, 0.005);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(5, d.data()), force.data(), nullptr, nullptr),
            PHN_WARNING_OUTSIDE | PHN_WARNING_INCOMPLETE);
  EXPECT_GT(force.norm(), 0);
  d = {0.0099, 0, 0};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(5, d.data()), force.data(), nullptr, nullptr),
            PHN_WARNING_INCOMPLETE);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, d.data()), force.data(), nullptr, nullptr), PHN_OK);
  d = {0.011, 0, 0};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, d.data()), force.data(), nullptr, nullptr),
            PHN_WARNING_OUTSIDE);
  d.setZero();
  const Trained at_rest(loaded.model, 5, d.data());
  EXPECT_EQ(at_rest.status, PHN_OK);
  EXPECT_EQ(at_rest.depth, 0.005);
}

}  // namespace
