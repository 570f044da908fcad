#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
constexpr double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();

class EveryInputOf : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, EveryInputOf, testing::Values(Family::rbfn, Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

// Claim: NaN and infinity are refused with zeros; every finite displacement, huge or subnormal, gives finite
// outputs.
TEST_P(EveryInputOf, NeverNaNOut) {
  const LoadedModel loaded(write_model_text(small_model_of(GetParam())));
  const double values[] = {nan, inf, -inf, huge, -huge, 1e200, tiny, -tiny, 1e-308, 0.0, -0.0, 0.01};
  for (const double x : values) {
    for (const double y : values) {
      for (const double z : values) {
        const double d[] = {x, y, z, z, x, y};
        const bool finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
        double force[3] = {nan, nan, nan};
        const int status = phn_force(loaded.model, loaded.data, AtNode(5, d), force, nullptr, nullptr);
        EXPECT_EQ(status < 0, !finite);
        for (const double f : force) EXPECT_TRUE(finite ? std::isfinite(f) : f == 0);
        double energy = nan, stiffness[9] = {nan, nan, nan, nan, nan, nan, nan, nan, nan};
        const bool derivatives = finite && GetParam() != Family::rbfn;
        EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(5, d), nullptr, &energy, nullptr) < 0, !derivatives);
        EXPECT_TRUE(derivatives ? std::isfinite(energy) : energy == 0);
        EXPECT_EQ(phn_force(loaded.model, loaded.data, AtNode(5, d), nullptr, nullptr, stiffness) < 0, !derivatives);
        for (const double k : stiffness) EXPECT_TRUE(derivatives ? std::isfinite(k) : k == 0);
        const Trained trained(loaded.model, 5, d);
        EXPECT_EQ(trained.status < 0, !finite);
        EXPECT_TRUE(finite ? std::isfinite(trained.depth) : trained.depth == 0);
        Points u = Points::Constant(12, 3, nan);
        EXPECT_EQ(phn_deform(loaded.model, loaded.data, AtNode(5, d), u.data()) < 0, !finite);
        EXPECT_TRUE(finite ? u.allFinite() : u.norm() == 0);
        if (finite && std::abs(x) > 1) {
          EXPECT_TRUE(status & PHN_WARNING_OUTSIDE);  // in linear models: beyond 1e100, where values are cut
        }
      }
    }
  }
}

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
    for (const double size : {0.0, 1e-3, 1.0, 1e6, 1e300}) {
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
}

// Claim: networks with large displacements and forces, full ones and smaller levels, have finite answers.
TEST(EveryInput, NetworksStayInTheRangeOfTheirNumbers) {
  for (const bool smaller_level : {false, true}) {
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

// Claim: memory one byte too small is refused, at any alignment; memory of the stated size suffices at any
// alignment.
TEST_P(EveryInputOf, SizesSufficeAtAnyAlignment) {
  const std::string text = write_model_text(small_model_of(GetParam()));
  std::size_t bytes = 0;
  ASSERT_EQ(phn_model_size(text.data(), text.size(), &bytes, nullptr), PHN_OK);
  std::vector<char> memory(bytes + 64);
  for (int shift = 0; shift < 64; ++shift) {
    const phn_model* model = nullptr;
    ASSERT_EQ(phn_model_init(memory.data() + shift, bytes, text.data(), text.size(), &model, nullptr), PHN_OK);
    std::size_t data_bytes = 0;
    ASSERT_EQ(phn_data_size(model, 1, &data_bytes), PHN_OK);
    std::vector<char> data_memory(data_bytes + 1);
    phn_data* data = nullptr;
    EXPECT_EQ(phn_data_init(data_memory.data() + shift % 2, data_bytes, model, 1, &data), PHN_OK);
    EXPECT_EQ(phn_data_init(data_memory.data(), data_bytes - 1, model, 1, &data), PHN_ERROR_BUFFER);
    EXPECT_EQ(data, nullptr);
  }
  for (std::size_t less = 1; less <= bytes; less += 97) {
    const phn_model* model = nullptr;
    EXPECT_EQ(phn_model_init(memory.data(), bytes - less, text.data(), text.size(), &model, nullptr), PHN_ERROR_BUFFER);
    EXPECT_EQ(model, nullptr);
  }
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
