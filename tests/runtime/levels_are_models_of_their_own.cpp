#include <gtest/gtest.h>

#include <limits>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;

constexpr std::int32_t touched[] = {3, 5, 8};

/// Everything that a model says of some displacements, one tool, several and coupled.
std::vector<double> answers(const LoadedModel& loaded) {
  std::vector<double> all;
  Numbers numbers;
  const auto* model = loaded.model;
  auto* data = loaded.data;
  const auto n_output = static_cast<std::size_t>(info_of(model).n_output);
  for (int i = 0; i < 20; ++i) {
    const std::int32_t node = touched[i % 3];
    double d[6], f[6] = {}, k[9];
    for (double& x : d) x = 0.012 * numbers.next();
    EXPECT_GE(phn_force(model, data, AtNode(node, d), f, nullptr, nullptr), 0);
    all.insert(all.end(), f, f + 3);
    phn_force(model, data, AtNode(node, d), nullptr, f, nullptr);
    all.push_back(f[0]);
    phn_force(model, data, AtNode(node, d), nullptr, nullptr, k);
    all.insert(all.end(), k, k + 9);
    std::vector<double> u(3 * n_output);
    EXPECT_GE(phn_deform(model, data, AtNode(node, d), u.data()), 0);
    all.insert(all.end(), u.begin(), u.end());
    for (std::int32_t field = 0; field < info_of(model).n_fields; ++field) {
      EXPECT_GE(phn_field(model, data, AtNode(node, d), field, u.data()), 0);
      all.insert(all.end(), u.begin(), u.begin() + static_cast<std::ptrdiff_t>(n_output));
    }
    const phn_tool tools[] = {{{3, 5, 0}, {0.25, 0.5, 0.25}, {d[0], d[1], d[2]}},
                              {{8, -1, -1}, {1, 0, 0}, {d[3], d[4], d[5]}}};
    phn_coupled result;
    EXPECT_GE(phn_couple(model, data, 2, tools, f, &result), 0);
    all.insert(all.end(), f, f + 6);
    all.push_back(result.energy);
    EXPECT_GE(phn_coupled_deform(model, data, u.data()), 0);
    all.insert(all.end(), u.begin(), u.end());
  }
  return all;
}

Model model_of(Family family) { return family == Family::modal ? small_field_model() : small_model(); }

class Levels : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, Levels, testing::Values(Family::rbfn, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

// Claim: a level says what a model made of that level alone says, to the last bit, whichever levels were
// asked before with the same data and whichever nodes are ready; the last level is the model without levels.
TEST_P(Levels, AnswerAsModelsOfTheirOwn) {
  const Model model = with_levels(model_of(GetParam()));
  const LoadedModel loaded(write_model_text(model));
  ASSERT_EQ(info_of(loaded.model).n_levels, 3);
  EXPECT_EQ(answers(loaded), answers(LoadedModel(write_model_text(model_of(GetParam())))));
  std::vector<double> before;
  for (const std::int32_t level : {0, 1, 2, 1, 0}) {
    ASSERT_EQ(phn_set_level(loaded.model, loaded.data, level), PHN_OK);
    const LoadedModel alone(write_model_text(level_alone(model, static_cast<std::size_t>(level))));
    const auto said = answers(loaded);
    EXPECT_EQ(said, answers(alone)) << level;
    EXPECT_NE(said, before);  // a switch that does nothing would not be seen by a model of equal levels
    before = said;
  }
}

// Claim: a level belongs to the data, not to the model.
TEST_P(Levels, AreThoseOfTheData) {
  const std::string text = write_model_text(with_levels(model_of(GetParam())));
  const LoadedModel loaded(text);
  std::size_t bytes = 0;
  ASSERT_EQ(phn_data_size(loaded.model, 1, &bytes), PHN_OK);
  std::vector<char> memory(bytes);
  phn_data* other = nullptr;
  ASSERT_EQ(phn_data_init(memory.data(), bytes, loaded.model, 1, &other), PHN_OK);
  ASSERT_EQ(phn_set_level(loaded.model, loaded.data, 0), PHN_OK);
  const double d[] = {0.001, 0.004, -0.002};
  double small[3], full[3], plain[3];
  ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(3, d), small, nullptr, nullptr), 0);
  ASSERT_GE(phn_force(loaded.model, other, AtNode(3, d), full, nullptr, nullptr), 0);
  const LoadedModel without(write_model_text(model_of(GetParam())));
  ASSERT_GE(phn_force(without.model, without.data, AtNode(3, d), plain, nullptr, nullptr), 0);
  EXPECT_NE(small[0], full[0]);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(full[k], plain[k]);
}

// Claim: the field of coupled tools is that of the level at which they were coupled.
TEST_P(Levels, AreKeptByCoupledTools) {
  const LoadedModel loaded(write_model_text(with_levels(model_of(GetParam()))));
  const phn_tool tool = {{3, 5, 8}, {0.25, 0.5, 0.25}, {0.001, -0.002, 0.003}};
  double force[3];
  Points kept(info_of(loaded.model).n_output, 3), u = kept;
  for (const std::int32_t level : {0, 2}) {
    ASSERT_EQ(phn_set_level(loaded.model, loaded.data, level), PHN_OK);
    ASSERT_GE(phn_couple(loaded.model, loaded.data, 1, &tool, force, nullptr), 0);
    ASSERT_GE(phn_coupled_deform(loaded.model, loaded.data, kept.data()), 0);
    ASSERT_EQ(phn_set_level(loaded.model, loaded.data, 1), PHN_OK);
    ASSERT_GE(phn_coupled_deform(loaded.model, loaded.data, u.data()), 0);
    EXPECT_EQ(u, kept);
  }
}

// Claim: info tells sizes and errors of the file; a model without levels has one, of unknown error.
TEST(LevelInfo, TellsWhatTheFileSays) {
  const LoadedModel modal(write_model_text(with_levels(small_modal_model()))),
      networks(write_model_text(with_levels(small_model()))), one(write_model_text(small_modal_model()));
  phn_level info;
  ASSERT_EQ(phn_level_info(modal.model, 0, &info), PHN_OK);
  EXPECT_EQ(info.force_centers, 2);
  EXPECT_EQ(info.deformation_centers, 2);
  EXPECT_EQ(info.modes, 1);
  EXPECT_EQ(info.error_force, 0.5);
  EXPECT_EQ(info.error_displacement, 0.25);
  ASSERT_EQ(phn_level_info(modal.model, 2, &info), PHN_OK);
  EXPECT_EQ(info.force_centers, 5);
  EXPECT_EQ(info.deformation_centers, 4);
  EXPECT_EQ(info.modes, 3);
  ASSERT_EQ(phn_level_info(networks.model, 1, &info), PHN_OK);
  EXPECT_EQ(info.force_centers, 4);
  EXPECT_EQ(info.deformation_centers, 6);
  EXPECT_EQ(info.modes, 0);
  EXPECT_EQ(info_of(one.model).n_levels, 1);
  ASSERT_EQ(phn_level_info(one.model, 0, &info), PHN_OK);
  EXPECT_EQ(info.force_centers, 5);
  EXPECT_EQ(info.error_force, 0);
  for (const std::int32_t level : {-1, 3, std::numeric_limits<std::int32_t>::max()}) {
    EXPECT_EQ(phn_level_info(modal.model, level, &info), PHN_ERROR_ARGUMENT);
    EXPECT_EQ(info.force_centers, 0);
    EXPECT_EQ(phn_set_level(modal.model, modal.data, level), PHN_ERROR_ARGUMENT);
  }
  EXPECT_EQ(phn_set_level(modal.model, one.data, 0), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_set_level(nullptr, one.data, 0), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_level_info(nullptr, 0, &info), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(phn_level_info(modal.model, 0, nullptr), PHN_ERROR_ARGUMENT);
  EXPECT_EQ(info_of(nullptr).n_levels, 0);
}

}  // namespace
