// Claims: validate says how far the probed nodes are from the fixed ones, and not that some are beside them; train,
// validate and the report say where a model is worse than the linear predictor, and only there.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class ValidationWords : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene("P1", 3));
    ASSERT_EQ(phynness("precompute scene.toml -o d.h5").exit_status, 0);
  }
};

TEST_F(ValidationWords, AreDistances) {
  ASSERT_EQ(phynness("train scene.toml d.h5 -o m --family modal").exit_status, 0);
  const auto validated = phynness("validate scene.toml m --probes 8 --json v.json");
  ASSERT_EQ(validated.exit_status, 0) << validated.err;
  const auto conditions = json("v.json").at("conditions");
  ASSERT_EQ(conditions.at("fixed_distances_m").size(), conditions.at("nodes").size());
  // The block is 50 mm high, touched on top and fixed at the bottom.
  for (const double distance : conditions.at("fixed_distances_m")) {
    EXPECT_GE(distance, 0.05);
    EXPECT_LT(distance, 0.06);
  }
  EXPECT_EQ(validated.out.find("next to"), std::string::npos) << validated.out;
  EXPECT_EQ(validated.out.find("beside"), std::string::npos) << validated.out;
  expect_names(validated.out, {" mm from the nearest fixed node"});
}

}  // namespace
}  // namespace phynness::test
