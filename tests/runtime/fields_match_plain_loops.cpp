#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Vector3d;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// The formulas of formats/model.md, "Fields", term by term.
Eigen::VectorXd plain(const Model& model, const ActiveNodeModel& node, std::size_t f, const Vector3d& d,
                      double& terms) {
  const Vector3d x = d / model.max_displacement_m;
  const double s = model.shared.shape;
  const auto n_centers = static_cast<Eigen::Index>(model.shared.centers.size());
  Eigen::VectorXd basis(n_centers + 9);
  for (Eigen::Index i = 0; i < n_centers; ++i) {
    const Vector3d c = model.displacements.row(model.shared.centers[static_cast<std::size_t>(i)]).transpose() /
                       model.max_displacement_m;
    basis[i] = q(x - c, s) - q(x, s) - q(c, s) + s;
  }
  basis.segment<3>(n_centers) = x;
  const double by = model.fields[f].degree == 1 ? x.norm() : 1;
  Eigen::Index at = n_centers + 3;
  for (int j = 0; j < 3; ++j)
    for (int k = j; k < 3; ++k) basis[at++] = x[j] * x[k] / by;
  const ModalDeformation& of_node = node.fields[f];
  const Eigen::VectorXd a = of_node.weights.values().transpose() * basis;
  const Eigen::VectorXd amounts = of_node.mixing.values() * a;
  Eigen::VectorXd values = model.fields[f].modes.values() * amounts;
  const Eigen::VectorXd near = of_node.near_modes.values() * a;
  for (std::size_t i = 0; i < of_node.near.size(); ++i) values[of_node.near[i]] = near[static_cast<Eigen::Index>(i)];
  terms = model.fields[f].scale * (model.fields[f].modes.values().cwiseAbs() * amounts.cwiseAbs()).maxCoeff();
  return (model.fields[f].scale * values).cwiseMax(0);
}

const Vector3d field_probes[] = {{0.004, -0.002, 0.001}, {0.01, 0, 0}, {-0.02, 0.03, 0.01}, {0, 0.005, 0}, {1, 1, -1}};

// Claim: a field is the formulas of formats/model.md. Shared modes are summed as floats: 1e-6 of the sizes of the terms
// is 16 roundings of 6e-8, of which 6 modes make. (Values at near nodes are sums in double, and of that size.)
TEST(Fields, MatchPlainLoops) {
  const Model model = small_field_model();
  const LoadedModel loaded(write_model_text(model));
  ASSERT_EQ(info_of(loaded.model).n_fields, 2);
  int positive = 0, cut = 0;
  for (const ActiveNodeModel& node : model.nodes)
    for (std::int32_t f = 0; f < 2; ++f) {
      if (node.fields[static_cast<std::size_t>(f)].weights.cols() == 0) continue;
      for (const Vector3d& d : field_probes) {
        double terms = 0;
        const auto expected = plain(model, node, static_cast<std::size_t>(f), d, terms);
        Eigen::VectorXd values = Eigen::VectorXd::Constant(12, not_a_number);
        const int status = phn_field(loaded.model, loaded.data, AtNode(node.node, d.data()), f, values.data());
        double force[3];
        EXPECT_EQ(status, phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force, nullptr, nullptr));
        ASSERT_GE(status, 0);
        EXPECT_LE((values - expected).cwiseAbs().maxCoeff(), 1e-6 * terms);
        positive += static_cast<int>((values.array() > 0).count());
        cut += static_cast<int>((values.array() == 0).count());
      }
    }
  // Random tables: both signs occur, and negative values are cut to zero.
  EXPECT_GT(positive, 50);
  EXPECT_GT(cut, 50);
}

// Claim: names and units are those of the text; what the model does not have is null or refused, with zeros.
TEST(Fields, SayWhatTheyAre) {
  const LoadedModel loaded(write_model_text(small_field_model())), without(write_model_text(small_modal_model()));
  EXPECT_STREQ(info_of(loaded.model).field_names[0], "von-mises-stress");
  EXPECT_STREQ(info_of(loaded.model).field_units[0], "Pa");
  EXPECT_STREQ(info_of(loaded.model).field_names[1], "energy-density");
  EXPECT_STREQ(info_of(loaded.model).field_units[1], "J/m^3");
  for (int field = 2; field < PHN_MOST_FIELDS; ++field) {
    EXPECT_EQ(info_of(loaded.model).field_names[field], nullptr);
    EXPECT_EQ(info_of(loaded.model).field_units[field], nullptr);
  }
  EXPECT_EQ(info_of(nullptr).n_fields, 0);
  EXPECT_EQ(info_of(without.model).n_fields, 0);
  const double d[3] = {0.001, 0, 0};
  double out[12];
  for (const std::int32_t field : {-1, 2, 1000}) {
    std::fill(out, out + 12, 1);
    EXPECT_EQ(phn_field(loaded.model, loaded.data, AtNode(3, d), field, out), PHN_ERROR_ARGUMENT);
    for (const double v : out) EXPECT_EQ(v, 0);
  }
  EXPECT_EQ(phn_field(without.model, without.data, AtNode(3, d), 0, out), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_field(loaded.model, loaded.data, AtNode(4, d), 0, out), PHN_ERROR_NOT_ACTIVE);
  std::fill(out, out + 12, 1);
  EXPECT_EQ(phn_field(loaded.model, loaded.data, AtNode(15, d), 1, out), PHN_ERROR_UNDEFINED);
  for (const double v : out) EXPECT_EQ(v, 0);
  EXPECT_EQ(phn_field(loaded.model, without.data, AtNode(3, d), 0, out), PHN_ERROR_ARGUMENT);
}

// Claim: the field of a round tool between nodes is the mean of the nodes' fields by the weights of the place; of node
// probes there it is not defined. Rounding of sums: 1e-14 of the largest value.
TEST(Fields, AreMeansUnderRoundTools) {
  Model model = small_field_model();
  const LoadedModel nodes(write_model_text(model));
  for (ActiveNodeModel& node : model.nodes) {
    node.moves_mean = node.node < 14;
    if (node.moves_mean) node.prescribed = {3, 5, 8};
    if (node.moves_mean) node.prescribed_weight = {0.25, 0.5, 0.25};
  }
  const LoadedModel loaded(write_model_text(model));
  const double d[3] = {0.003, -0.002, 0.004};
  const phn_tool held = {{3, 5, 8}, {0.5, 0.3, 0.2}, {d[0], d[1], d[2]}};
  for (const std::int32_t f : {0, 1}) {
    Eigen::ArrayXd mean = Eigen::ArrayXd::Zero(12), one(12);
    for (int k = 0; k < 3; ++k) {
      ASSERT_GE(phn_field(loaded.model, loaded.data, AtNode(held.nodes[k], d), f, one.data()), 0);
      mean += held.weights[k] * one;
    }
    ASSERT_GE(phn_field(loaded.model, loaded.data, &held, f, one.data()), 0);
    EXPECT_LE((one - mean).abs().maxCoeff(), 1e-14 * mean.maxCoeff());
    EXPECT_GT(mean.maxCoeff(), 0);
    EXPECT_EQ(phn_field(nodes.model, nodes.data, &held, f, one.data()), PHN_ERROR_UNDEFINED);
    EXPECT_EQ(one.maxCoeff(), 0);
  }
}

// Claim: at the bounds of the format, all at once, no float overflows.
TEST(Fields, StayFiniteAtTheBoundsOfTheFormat) {
  Model model = small_modal_model(1, 1, 1, 8);
  model.nodes.resize(1);
  const auto full = [](Eigen::Index rows, Eigen::Index columns) {
    ScaledTable table;
    table.scale = Eigen::VectorXd::Constant(columns, 1e6 / 32767 * (1 - 1e-15));
    table.entries.setConstant(rows, columns, 32767);
    return table;
  };
  model.fields = {{"f", "u", 2, 1e100, full(12, 1024)}};
  ModalDeformation of_node;
  of_node.near = {3};
  of_node.weights = full(8 + 9, 1024);
  of_node.mixing = full(1024, 1024);
  of_node.near_modes = full(1, 1024);
  model.nodes[0].fields = {of_node};
  const LoadedModel loaded(write_model_text(model));
  for (const double size : {1.0, 1e300}) {
    const double d[3] = {size, size, size};
    double out[12];
    ASSERT_GE(phn_field(loaded.model, loaded.data, AtNode(model.nodes[0].node, d), 0, out), 0);
    for (const double v : out) EXPECT_TRUE(std::isfinite(v));
    // The bound would be idle if values stayed small: scale 1e100 and sums of 1e30 at least.
    if (size > 1) {
      EXPECT_GT(out[0], 1e130);
    }
  }
}

}  // namespace
