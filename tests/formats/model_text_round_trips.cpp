#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <locale>
#include <phynness/formats/model.hpp>
#include <sstream>

#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

// Claim: a model comes back bit for bit, scaled centers included, though the file holds only their indices.
TEST(ModelText, RoundTripsBitForBit) {
  Model model = small_model();
  // Values that a decimal or sloppy writer loses: negative zero, the smallest subnormal, the largest double's
  // neighbour.
  model.nodes[0].force.weights(0, 0) = -0.0;
  model.nodes[0].force.weights(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].force.weights(0, 2) = 0x1.ffffffffffffep+900;
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].force.centers, model.nodes[i].force.centers);
    EXPECT_EQ(again.nodes[i].deformation.centers, model.nodes[i].deformation.centers);
    EXPECT_EQ(again.nodes[i].deformation.weights, model.nodes[i].deformation.weights);
    EXPECT_EQ(again.nodes[i].prescribed_weight, model.nodes[i].prescribed_weight);
    EXPECT_EQ(again.nodes[i].n_incomplete, model.nodes[i].n_incomplete);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].force.weights(0, 0)));
  EXPECT_EQ(again.title, model.title);
  EXPECT_EQ(again.fixed, model.fixed);
  EXPECT_EQ(again.fixed_points, model.fixed_points);
  EXPECT_EQ(again.surface, model.surface);
}

// Claim: a linear model comes back bit for bit.
TEST(ModelText, LinearResponsesRoundTripBitForBit) {
  Model model = small_linear_model();
  model.nodes[0].linear.unit_responses(0, 0) = -0.0;
  model.nodes[0].linear.unit_responses(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].linear.unit_responses(0, 2) = -largest_linear_entry;
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  EXPECT_EQ(again.family, Family::linear);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    EXPECT_EQ(again.nodes[i].linear.stiffness, model.nodes[i].linear.stiffness);
    EXPECT_EQ(again.nodes[i].linear.unit_responses, model.nodes[i].linear.unit_responses);
    EXPECT_EQ(again.nodes[i].prescribed_weight, model.nodes[i].prescribed_weight);
    EXPECT_EQ(again.nodes[i].trained_depth_m, model.nodes[i].trained_depth_m);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].linear.unit_responses(0, 0)));
}

// Claim: a modal model comes back bit for bit, integers and scales of tables included, with and without
// modes.
TEST(ModelText, ModalModelsRoundTripBitForBit) {
  Model model = small_modal_model();
  model.nodes[0].conservative.coefficients(0, 0) = -0.0;
  model.nodes[0].conservative.coefficients(0, 1) = 0x0.0000000000001p-1022;
  model.nodes[0].conservative.coefficients(0, 2) = -largest_linear_entry;
  model.nodes[0].modal.mixing.entries(0, 0) = -32767;
  ModalDeformation& bare = model.nodes[3].modal;
  for (ScaledTable* table : {&bare.weights, &bare.mixing, &bare.near_modes})
    *table = scaled_table(Eigen::MatrixXd(table->rows(), 0));
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  EXPECT_EQ(again.family, Family::modal);
  const auto equal = [](const ScaledTable& a, const ScaledTable& b) {
    return a.scale == b.scale && a.entries == b.entries;
  };
  EXPECT_TRUE(equal(again.shared.modes, model.shared.modes));
  EXPECT_EQ(again.shared.centers, model.shared.centers);
  EXPECT_EQ(again.shared.shape, model.shared.shape);
  ASSERT_EQ(again.nodes.size(), model.nodes.size());
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    const ConservativeNetwork &force = again.nodes[i].conservative, &wanted = model.nodes[i].conservative;
    EXPECT_EQ(force.shape, wanted.shape);
    EXPECT_EQ(force.stiffness, wanted.stiffness);
    EXPECT_EQ(force.centers, wanted.centers);
    EXPECT_EQ(force.coefficients, wanted.coefficients);
    EXPECT_TRUE(equal(again.nodes[i].modal.weights, model.nodes[i].modal.weights));
    EXPECT_TRUE(equal(again.nodes[i].modal.mixing, model.nodes[i].modal.mixing));
    EXPECT_TRUE(equal(again.nodes[i].modal.near_modes, model.nodes[i].modal.near_modes));
    EXPECT_EQ(again.nodes[i].modal.near, model.nodes[i].modal.near);
  }
  EXPECT_TRUE(std::signbit(again.nodes[0].conservative.coefficients(0, 0)));
}

// Claim: so does one with fields; without them the text has no trace of any.
TEST(ModelText, FieldsRoundTripBitForBit) {
  const Model model = small_field_model();
  const std::string text = write_model_text(model);
  const Model again = read_model_text(text, "model.txt");
  EXPECT_EQ(write_model_text(again), text);
  const auto equal = [](const ScaledTable& a, const ScaledTable& b) {
    return a.scale == b.scale && a.entries == b.entries;
  };
  ASSERT_EQ(again.fields.size(), 2u);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_EQ(again.fields[f].name, model.fields[f].name);
    EXPECT_EQ(again.fields[f].unit, model.fields[f].unit);
    EXPECT_EQ(again.fields[f].degree, model.fields[f].degree);
    EXPECT_EQ(again.fields[f].scale, model.fields[f].scale);
    EXPECT_TRUE(equal(again.fields[f].modes, model.fields[f].modes));
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      EXPECT_TRUE(equal(again.nodes[i].fields[f].weights, model.nodes[i].fields[f].weights));
      EXPECT_TRUE(equal(again.nodes[i].fields[f].mixing, model.nodes[i].fields[f].mixing));
      EXPECT_TRUE(equal(again.nodes[i].fields[f].near_modes, model.nodes[i].fields[f].near_modes));
      EXPECT_EQ(again.nodes[i].fields[f].near, model.nodes[i].fields[f].near);
    }
  }
  EXPECT_EQ(write_model_text(small_modal_model()).find("field"), std::string::npos);
}

// Claim: so does one with bounds and a distance to a finer solution, with and without levels; without them the text has
// no trace of any.
TEST(ModelText, BoundsRoundTripBitForBit) {
  for (const Model& plain : {small_modal_model(), with_levels(small_model())}) {
    Model model = with_bound_between(plain);
    model.finer = {true, "p1-p1", "taylor-hood", 12, 0.03, 0.25, 0.5, 300, 13};
    model.solved = {true, "p1-p1", 1e3 / 3};
    const std::string text = write_model_text(model);
    const Model again = read_model_text(text, "text");
    EXPECT_EQ(write_model_text(again), text);
    ASSERT_EQ(again.bounds.size(), 1u);
    EXPECT_EQ(again.bounds[0].coverage, 0.95);
    EXPECT_EQ(again.bounds[0].n_rays, 1000);
    EXPECT_EQ(again.bounds[0].n_nodes, 50);
    EXPECT_EQ(again.bounds[0].between, model.bounds[0].between);
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      ASSERT_EQ(again.nodes[i].bounds.size(), 1u);
      EXPECT_EQ(again.nodes[i].bounds[0].scale, model.nodes[i].bounds[0].scale);
      EXPECT_EQ(again.nodes[i].bounds[0].entries, model.nodes[i].bounds[0].entries);
    }
    const auto figures_of = [](const FinerDistance& f) {
      return std::tuple(f.is_measured, f.element, f.reference, f.probes, f.tool_radius_m, f.mean, f.p95, f.nodes,
                        f.solved);
    };
    EXPECT_EQ(figures_of(again.finer), figures_of(model.finer));
    EXPECT_EQ(again.solved.element, "p1-p1");
    EXPECT_EQ(again.solved.shear_modulus_Pa, 1e3 / 3);
    for (const char* word : {"bound", "finer", "solved"})
      EXPECT_EQ(write_model_text(plain).find(word), std::string::npos) << word;
  }
}

// Claim: levels come back bit for bit, of networks and of modes with fields.
TEST(ModelText, LevelsRoundTripBitForBit) {
  for (const Model& model : {with_levels(small_model()), with_levels(small_field_model(), 2)}) {
    const std::string text = write_model_text(model);
    const Model again = read_model_text(text, "text");
    EXPECT_EQ(write_model_text(again), text);
    ASSERT_EQ(again.levels.size(), model.levels.size());
    for (std::size_t l = 0; l < model.levels.size(); ++l) {
      EXPECT_EQ(again.levels[l].error_force, model.levels[l].error_force);
      EXPECT_EQ(again.levels[l].error_displacement, model.levels[l].error_displacement);
      EXPECT_EQ(again.levels[l].centers, model.levels[l].centers);
    }
    for (std::size_t i = 0; i < model.nodes.size(); ++i) {
      ASSERT_EQ(again.nodes[i].levels.size() + 1, model.levels.size());
      const auto &level = model.nodes[i].levels[0], &same = again.nodes[i].levels[0];
      EXPECT_EQ(same.force.weights, level.force.weights);
      EXPECT_EQ(same.deformation.bias, level.deformation.bias);
      EXPECT_EQ(same.conservative.coefficients, level.conservative.coefficients);
      EXPECT_EQ(same.weights.entries, level.weights.entries);
      EXPECT_EQ(same.field_weights.size(), level.field_weights.size());
    }
  }
}

// Claim: a scaled table holds every number to 1 / 65534 of its column's largest, and zeros as zeros.
TEST(ModelText, TablesRoundToTheirColumns) {
  Numbers numbers;
  Eigen::MatrixXd values(50, 4);
  for (Eigen::Index r = 0; r < 50; ++r) {
    for (Eigen::Index c = 0; c < 4; ++c) values(r, c) = std::pow(10, 3 * c - 6) * numbers.next();
  }
  values.col(2).setZero();
  const ScaledTable table = scaled_table(values);
  for (Eigen::Index c = 0; c < 4; ++c) {
    // 1e-12 for the rounding of scale and product.
    EXPECT_LE((table.values().col(c) - values.col(c)).cwiseAbs().maxCoeff(),
              values.col(c).cwiseAbs().maxCoeff() / 65534 * (1 + 1e-12));
  }
  EXPECT_EQ(table.values().col(2).norm(), 0);
}

// Claim: networks are laid out as formats/model.md has it, so models that exist stay readable. The first
// word of every line from the family on; # for a line that begins with a number.
TEST(ModelText, NetworksAreLaidOutAsDescribed) {
  Model model = small_model(1, 1);
  model.nodes.resize(1);
  const std::string text = write_model_text(model);
  std::istringstream lines(text.substr(text.find("\nfamily") + 1));
  std::string line, layout;
  while (std::getline(lines, line)) {
    const std::string word = line.substr(0, line.find(' '));
    layout += word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == std::string::npos ? word + ' ' : "#";
  }
  const std::string transforms = "input_center input_half_range output_center output_half_range spread bias #";
  EXPECT_EQ(layout,
            "family title software mesh_hash physics_hash max_displacement_m mesh_nodes directions ####"
            "displacements ########fixed ##output ############surface ####active node point prescribed #incomplete "
            "trained_depth ####force " +
                transforms + "deformation " + transforms + "checksum ");
}

struct CommaNumbers : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

// Claim: the locale of the process changes neither what is written nor what is read. The C++ locale is made
// here; the C locale takes part where the system has one with a comma.
TEST(ModelText, IgnoresTheLocale) {
  const std::string text = write_model_text(small_model());
  const std::locale before = std::locale::global(std::locale(std::locale(), new CommaNumbers));
  std::setlocale(LC_ALL, "de_DE.UTF-8");
  EXPECT_EQ(write_model_text(small_model()), text);
  EXPECT_EQ(write_model_text(read_model_text(text, "model.txt")), text);
  std::locale::global(before);
  std::setlocale(LC_ALL, "C");
}

}  // namespace
