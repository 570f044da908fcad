// Claim: an interrupted validation reports its finished probes and states that they are not all. The same seed begins
// with the same probes, so that a run with this number of probes gives the same figures.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class InterruptedValidation : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", with_active(small_scene("P1", 2), active_top));
    make_once({"run scene.toml -o out"});
  }

  /// More probes than a minute solves; SIGINT when the progress has counted to `count` in `unit`.
  Outcome interrupted(const std::string& unit, const std::string& options) const {
    return CommandLine::interrupted("validate scene.toml out/model --json part.json " + options,
                                    "[1-9][0-9]/[0-9]+ " + unit);
  }
};

TEST_F(InterruptedValidation, OfRays) {
  const auto stopped = interrupted("rays", "--probes 100000 --points 5 --pairs 5");
  EXPECT_EQ(stopped.exit_status, 1);
  expect_names(stopped.err, {"interrupted", "0 of 5 points"});
  const auto part = json("part.json");
  EXPECT_TRUE(part.at("interrupted").get<bool>());
  const long finished = part.at("rays_finished");
  EXPECT_GE(finished, 10);
  EXPECT_LT(finished, part.at("rays").get<long>());
  EXPECT_GT(part.at("inside").at("force").at("n").get<long>(), 0);
  EXPECT_LE(part.at("inside").at("force").at("n").get<long>(), finished);
  EXPECT_FALSE(part.contains("points"));
}

TEST_F(InterruptedValidation, OfPointsAndPairs) {
  for (const std::string unit : {"points", "pairs"}) {
    const auto stopped = interrupted(unit, "--probes 2 --" + unit + " 100000");
    EXPECT_EQ(stopped.exit_status, 1);
    EXPECT_NE(stopped.err.find("of 100000 " + unit), std::string::npos) << stopped.err;
    const auto part = json("part.json").at(unit);
    EXPECT_TRUE(json("part.json").at("interrupted").get<bool>());
    const long finished = part.at("finished");
    EXPECT_GE(finished, 10);
    EXPECT_LT(finished, 100000);
    succeed("validate scene.toml out/model --probes 2 --json whole.json --" + unit + " " + std::to_string(finished));
    EXPECT_FALSE(json("whole.json").at("interrupted").get<bool>());
    auto whole = json("whole.json").at(unit);
    whole[unit] = 100000;  // what was asked for is all that may differ
    EXPECT_EQ(whole, part);
  }
}

}  // namespace
}  // namespace phynness::test
