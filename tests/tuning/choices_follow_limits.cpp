// Claim: the front contains exactly the models for which no other model is better in everything. The selected model is
// the cheapest one within the limits; otherwise the result names the missed limit and the factor.
#include <gtest/gtest.h>

#include <phynness/validation/tuning.hpp>

#include "../messages.hpp"

namespace phynness {
namespace {

using test::expect_names;

MeasuredModel measured(const std::string& name, double error, double us, double megabytes) {
  MeasuredModel m;
  m.candidate.name = name;
  m.errors.inside.force.mean = error / 2;
  m.errors.inside.displacement.mean = error;
  m.errors.inside.force.n = m.errors.inside.displacement.n = 20;
  m.speed.deformation_us = us;
  m.memory_bytes = 1e6 * megabytes;
  return m;
}

std::vector<MeasuredModel> some() {
  return {measured("small", 0.05, 1, 0.5), measured("middle", 0.02, 3, 1), measured("large", 0.005, 9, 4),
          measured("slow", 0.02, 300, 6), measured("compact", 0.04, 5, 0.3)};
}

TEST(Front, HoldsWhatNoneBeats) {
  auto models = some();
  models.push_back(measured("twin", 0.02, 3, 1));  // as good as "middle" in everything: both stay
  mark_front(models);
  std::string front;
  for (const auto& m : models)
    if (m.on_front) front += m.candidate.name + " ";
  EXPECT_EQ(front, "small middle large compact twin ");
}

TEST(Choice, IsTheFastestWithinTheError) {
  const auto models = some();
  EXPECT_EQ(choose_model(models, {.error = 0.05}).chosen, 0u);
  EXPECT_EQ(choose_model(models, {.error = 0.03}).chosen, 1u);
  EXPECT_EQ(choose_model(models, {.error = 0.01}).chosen, 2u);
}

TEST(Choice, IsTheMostAccurateWithoutALimitOfTheError) {
  const auto models = some();
  EXPECT_EQ(choose_model(models, {}).chosen, 2u);
  EXPECT_EQ(choose_model(models, {.deformation_us = 4}).chosen, 1u);
}

TEST(Choice, CountsTheWorseOfForceAndDisplacement) {
  auto models = some();
  models[0].errors.inside.force.mean = 0.5;
  EXPECT_EQ(choose_model(models, {.error = 0.05}).chosen, 1u);
}

TEST(Choice, SaysWhichLimitIsMissed) {
  const auto one = choose_model(some(), {.error = 0.001});
  EXPECT_FALSE(one.chosen);
  expect_names(one.missed, {"0.5 %", "large", "5 times", "0.1 %"});
  const auto two = choose_model(some(), {.error = 0.001, .deformation_us = 0.5});
  EXPECT_NE(two.missed.find("0.5 %"), std::string::npos) << two.missed;
  expect_names(two.missed, {"deformation", "1 us", "small", "2 times"});
  const auto together = choose_model(some(), {.error = 0.01, .deformation_us = 2});
  EXPECT_FALSE(together.chosen);
  expect_names(together.missed, {"middle", "2 %", "1 %", "deformation"});
}

TEST(Choice, IsNoneWhereNoErrorIsKnown) {
  auto models = some();
  for (auto& m : models) m.errors = {};  // no probe was solved: zeros that are no errors
  const auto choice = choose_model(models, {.error = 0.05});
  EXPECT_FALSE(choice.chosen);
  EXPECT_NE(choice.missed.find("no probe"), std::string::npos) << choice.missed;
  EXPECT_FALSE(choose_model(models, {}).chosen);
}

TEST(Candidates, AreAllowedByTheLaw) {
  Scene scene;
  scene.material.law = law_named("neo-hookean");
  bool modal = false;
  for (const auto& c : tuning_candidates(scene)) {
    EXPECT_NE(c.spec.family, Family::linear) << c.name;
    modal = modal || c.spec.family == Family::modal;
  }
  EXPECT_TRUE(modal);
  scene.material.law = law_named("linear");
  EXPECT_EQ(tuning_candidates(scene).front().spec.family, Family::linear);
}

}  // namespace
}  // namespace phynness
