#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), huge = std::numeric_limits<double>::max();

// Claim: at the bounds of the format, all at once (tables of 1e6, 1024 modes, coefficients of 1e100, the
// narrowest kernel, the largest displacement), outputs of a modal model stay finite.
TEST(EveryInput, TheLargestModalModelStaysFinite) {
  for (const double max_displacement : {1e-90, 1e90}) {
    Model model = small_modal_model(1024, 8, 1024, 8);
    model.displacements *= 900 * max_displacement / model.max_displacement_m;
    model.max_displacement_m = max_displacement;
    model.nodes.resize(1);
    const auto fill = [](ScaledTable& table) {
      table.scale.setConstant(1e6 / 32767 * (1 - 1e-15));
      table.entries.setConstant(32767);
    };
    ActiveNodeModel& node = model.nodes[0];
    for (ScaledTable* table : {&model.shared.modes, &node.modal.weights, &node.modal.mixing, &node.modal.near_modes})
      fill(*table);
    node.conservative.coefficients.setConstant(1e100);
    node.conservative.stiffness.setConstant(1e100);
    node.conservative.shape = model.shared.shape = 1e-6;
    const LoadedModel loaded(write_model_text(model));
    for (const double size : {0.0, 1e-3, 1.0, 1e6, 1e300})
      for (const double sign : {1.0, -1.0}) {
        const double length = std::min(size * max_displacement, huge);
        const double d[] = {sign * length, length, sign * length};
        double force[3] = {nan, nan, nan}, energy = nan, stiffness[9] = {nan};
        Points u = Points::Constant(12, 3, nan);
        EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(3, d), force, nullptr, nullptr), 0);
        EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(3, d), nullptr, &energy, nullptr), 0);
        EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(3, d), nullptr, nullptr, stiffness), 0);
        EXPECT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d), u.data()), 0);
        for (const double f : force) EXPECT_LT(std::abs(f), 1e300);
        EXPECT_LT(std::abs(energy), 1e300);
        for (const double k : stiffness) EXPECT_LT(std::abs(k), 1e300);
        EXPECT_TRUE(u.allFinite());
        if (size == 1e6) {
          EXPECT_GT(u.cwiseAbs().maxCoeff(), 1e25);
        }
      }
  }
}

// Claim: networks with large displacements and forces, full ones and smaller levels, have finite answers.
TEST(EveryInput, NetworksStayInTheRangeOfTheirNumbers) {
  for (const bool smaller_level : {false, true})
    for (const double reach : {1e35, 1e40}) {
      Model model = with_levels(small_model());
      ActiveNodeModel& node = model.nodes[0];
      node.force.output_half_range.setConstant(1e200);
      node.deformation.output_half_range.setConstant(1e20);
      (smaller_level ? node.levels[0].deformation.weights : node.deformation.weights).setConstant(reach / 1e21);
      const std::string text = write_model_text(model);
      const LoadedModel loaded(text);
      const double d[] = {0.001, 0.002, -0.003};
      for (const std::int32_t level : {0, 2}) {
        ASSERT_EQ(phn_set_level(loaded.model, loaded.data, level), PHN_OK);
        double force[3];
        Points u(12, 3);
        EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d), force, nullptr, nullptr), 0);
        EXPECT_TRUE(Eigen::Vector3d(force[0], force[1], force[2]).allFinite());
        EXPECT_GE(phn_deform(loaded.model, loaded.data, AtNode(node.node, d), u.data()), 0);
        EXPECT_TRUE(u.allFinite());
        if ((level == 0) == smaller_level) {
          EXPECT_GT(u.cwiseAbs().maxCoeff(), 0.01 * reach);
        }
      }
    }
}

// Claim: what a model does not define is refused with zeros: energy and stiffness of networks, the
// deformation of a node with forces only, alone or among several tools. What it defines stays.
TEST(EveryInput, WhatIsUndefinedIsNamed) {
  const double d[6] = {0.001, 0.002, 0, 0, 0.001, 0};
  const LoadedModel networks(write_model_text(small_model()));
  double energy = 1, stiffness[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1}, force[3];
  EXPECT_EQ(phn_force(networks.model, networks.data, AtNode(3, d), nullptr, &energy, nullptr), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(energy, 0);
  EXPECT_EQ(phn_force(networks.model, networks.data, AtNode(3, d), nullptr, nullptr, stiffness), PHN_ERROR_UNDEFINED);
  for (const double k : stiffness) EXPECT_EQ(k, 0);

  Model model = small_modal_model();
  ModalDeformation& bare = model.nodes[0].modal;
  for (ScaledTable* table : {&bare.weights, &bare.mixing, &bare.near_modes})
    *table = scaled_table(Eigen::MatrixXd(table->rows(), 0));
  const LoadedModel loaded(write_model_text(model));
  const std::int32_t tools[] = {5, 3};
  Points u = Points::Ones(12, 3);
  EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(tools[1], d), u.data()), PHN_ERROR_UNDEFINED);
  EXPECT_EQ(u.norm(), 0);
  EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(*tools, d), u.data()), PHN_WARNING_INCOMPLETE);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, d), force, nullptr, nullptr), PHN_OK);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, d), nullptr, &energy, nullptr), PHN_OK);
  EXPECT_GT(energy, 0);
}

// Claim: each misuse has its own status and leaves zeros.
TEST(EveryInput, MisuseIsNamed) {
  const std::string text = write_model_text(small_model());
  const LoadedModel loaded(text, 2), other(text, 2);
  const double d[9] = {0.001, 0, 0, 0.001, 0, 0, 0.001, 0, 0};
  double force[3] = {1, 1, 1};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(4, d), force, nullptr, nullptr), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(force[0], 0);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(-1, d), force, nullptr, nullptr), PHN_ERROR_NOT_ACTIVE);
  const double no_number[3] = {std::nan(""), 0, 0};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(4, no_number), force, nullptr, nullptr), PHN_ERROR_NOT_FINITE);
  EXPECT_EQ(phn_force(nullptr, loaded.data, AtNode(3, d), force, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, nullptr, AtNode(3, d), force, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, other.data, AtNode(3, d), force, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, nullptr), force, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, d), nullptr, nullptr, nullptr), PHN_ERROR_ARGUMENT);
  double stiffness[9] = {1};
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(4, d), nullptr, force, nullptr), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(phn_force(loaded.model, other.data, AtNode(3, d), nullptr, force, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(4, d), nullptr, nullptr, stiffness), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(stiffness[0], 0);
  EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(3, nullptr), nullptr, nullptr, stiffness), PHN_ERROR_ARGUMENT);
  Points u = Points::Ones(12, 3);
  EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(3, nullptr), u.data()), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(4, d), u.data()), PHN_ERROR_NOT_ACTIVE);
  EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(3, d), nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_coupled_deform(loaded.model, nullptr, u.data()), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_depth(loaded.model, AtNode(3, d), nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_nearest(loaded.model, nullptr, nullptr, u.data(), nullptr), PHN_ERROR_ARGUMENT);
  std::size_t bytes = 0;
  EXPECT_EQ(phn_data_size(nullptr, 1, &bytes), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(info_of(nullptr).n_nodes, 0);
}

// Claim: every status has its own sentence.
TEST(EveryInput, StatusesHaveWords) {
  std::vector<std::string> messages;
  for (const int status : {0, 1, 2, 3, -1, -2, -3, -4, -5, -6, -7, -10, -11, -12, -13, -14, -15, -16, -99}) {
    for (const std::string& other : messages) EXPECT_NE(other, phn_status_message(status));
    messages.push_back(phn_status_message(status));
  }
}

}  // namespace
