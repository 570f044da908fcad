// Claims: validate says how far the probed nodes are from the fixed ones, and not that some are beside them; train,
// validate and the report say where a model is worse than the linear predictor, and only there.
#include <set>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class ValidationWords : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene("P1", 3));
    make_once({"precompute scene.toml -o d.h5"});
  }
};

TEST_F(ValidationWords, AreDistances) {
  succeed("train scene.toml d.h5 -o m --family modal");
  const auto validated = succeed("validate scene.toml m --probes 8 --report r.html --json v.json");
  const auto conditions = json("v.json").at("conditions");
  ASSERT_EQ(conditions.at("fixed_distances_m").size(), conditions.at("nodes").size());
  // The block is 50 mm high, touched on top and fixed at the bottom.
  for (const double distance : conditions.at("fixed_distances_m")) {
    EXPECT_GE(distance, 0.05);
    EXPECT_LT(distance, 0.06);
  }
  EXPECT_EQ(validated.out.find("next to"), std::string::npos) << validated.out;
  EXPECT_EQ(validated.out.find("beside"), std::string::npos) << validated.out;
  expect_names(read_file(folder / "r.html"), {" mm from the nearest fixed node"});
}

TEST_F(ValidationWords, NameWhatIsWorseThanLinear) {
  // A single neuron cannot repeat a deformation; 16 modes can.
  succeed("train scene.toml d.h5 -o poor --family rbfn --set deformation_neurons=1 --set force_neurons=1");
  const auto validated = succeed("validate scene.toml poor --probes 8 --json v.json --report r.html");
  expect_names(validated.out, {"worse than the linear predictor", "displacement"});
  std::set<std::string> ranges;
  const auto result = json("v.json");
  for (const auto& worse : result.at("worse_than_linear")) {
    EXPECT_GT(worse.at("model").get<double>(), worse.at("linear").get<double>());
    ranges.insert(worse.at("range").get<std::string>());
  }
  EXPECT_TRUE(ranges.count("inside") || ranges.count("outside")) << result;
  expect_names(read_file(folder / "r.html"), {"worse than the linear predictor"});

  succeed("train scene.toml d.h5 -o good --family modal");
  succeed("validate scene.toml good --probes 8 --json v.json");
  EXPECT_TRUE(json("v.json").at("worse_than_linear").empty()) << json("v.json").at("worse_than_linear");
}

}  // namespace
}  // namespace phynness::test
