// Claims: eval --motion gives for each step exactly the forces and energies of eval for its tools, for families with
// and without energy, for one tool, for several, and for tools between nodes. A tool that does not touch changes
// nothing. Its answer is a motion again, whose repetition has no difference. A motion that the model cannot answer is
// refused with its step, and no file is written.
#include <cmath>
#include <cstdio>

#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

using Json = nlohmann::json;

class Motions : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
    succeed("precompute scene.toml -o d.h5");
    for (const char* family : {"rbfn", "modal"})
      succeed(std::string("train scene.toml d.h5 --family ") + family + " -o " + family);
    succeed("info d.h5 --json info.json");
    nodes = json("info.json").at("active").get<std::vector<int>>();
    ASSERT_EQ(nodes.size(), 2u);
  }

  Json one_tool() const {
    return {{"format", "phynness motion 1"},
            {"tools", {{{"node", nodes[0]}}}},
            {"time_s", {0.0, 0.5, 0.5}},
            {"displacement_m", {{{0.0, 0.0, 0.0}}, {{0.0012345678901234567, -1e-4, 0.003}}, {{0.011, 0.005, -0.02}}}}};
  }

  Json answer(const Json& motion, const std::string& model = "modal") {
    write_file(folder / "motion.json", motion.dump());
    outcome = phynness("eval " + model + " --motion motion.json --json answer.json");
    EXPECT_EQ(outcome.exit_status, 0) << outcome.err;
    return json("answer.json");
  }

  void expect_refused(const Json& motion, const std::vector<std::string>& parts) const {
    write_file(folder / "bad.json", motion.dump());
    const auto refused = be_refused("eval modal --motion bad.json --json none.json");
    EXPECT_EQ(refused.out, "");
    EXPECT_FALSE(std::filesystem::exists(folder / "none.json"));
    expect_error(refused.err, parts);
  }

  /// As an option of eval; 17 digits name a double exactly.
  static std::string displacement(const Json& d) {
    char text[120];
    std::snprintf(text, sizeof text, " --displacement %.17g,%.17g,%.17g", d[0].get<double>(), d[1].get<double>(),
                  d[2].get<double>());
    return text;
  }

  std::vector<int> nodes;
  Outcome outcome;
};

TEST_F(Motions, AreAnsweredAsOneByOne) {
  const auto motion = one_tool();
  for (const std::string family : {"rbfn", "modal"}) {
    const auto all = answer(motion, family);
    EXPECT_EQ(all.at("family"), family);
    EXPECT_EQ(all.at("displacement_m"), motion["displacement_m"]);
    EXPECT_EQ(all.contains("energy_J"), family == "modal");
    bool warned = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto one = succeed("eval " + family + " --node " + std::to_string(nodes[0]) +
                               displacement(motion["displacement_m"][i][0]) + " --json one.json");
      const auto single = json("one.json");
      EXPECT_EQ(all.at("force_N")[i][0], single.at("tools")[0].at("force")) << family << i;
      if (family == "modal") {
        EXPECT_EQ(all.at("energy_J")[i], single.at("energy")) << i;
      }
      EXPECT_EQ(all.at("status")[i], single.at("status")) << family << i;
      warned = warned || all.at("status")[i] != 0;
    }
    EXPECT_TRUE(warned);
    EXPECT_NE(outcome.out.find("3 steps of 1 tool in 0.5 s"), std::string::npos) << outcome.out;
  }
}

TEST_F(Motions, OfSeveralToolsAreCoupled) {
  Json motion = one_tool();
  motion["tools"].push_back({{"node", nodes[1]}});
  const Json first{0.0, 0.001, -0.004}, second{0.002, 0.0, -0.003};
  motion["displacement_m"] =
      Json::array({Json::array({first, second}), Json::array({first, nullptr}), Json::array({nullptr, nullptr})});
  const auto all = answer(motion);
  const auto a = " --node " + std::to_string(nodes[0]), b = " --node " + std::to_string(nodes[1]);
  ASSERT_EQ(
      phynness("eval modal" + a + b + displacement(first) + displacement(second) + " --json two.json").exit_status, 0);
  succeed("eval modal" + a + displacement(first) + " --json one.json");
  const auto two = json("two.json"), one = json("one.json");
  for (std::size_t t = 0; t < 2; ++t) EXPECT_EQ(all["force_N"][0][t], two["tools"][t]["force"]) << t;
  EXPECT_EQ(all["energy_J"][0], two["energy"]);
  EXPECT_EQ(all["force_N"][1][0], one["tools"][0]["force"]);
  EXPECT_TRUE(all["force_N"][1][1].is_null());
  EXPECT_TRUE(all["force_N"][2][0].is_null());
  EXPECT_EQ(all["energy_J"][2], 0.0);
}

// eval finds nodes and weights of a point itself; the motion names them. All nodes around this point of the sample
// model are active.
TEST_F(Motions, BetweenNodesAreThoseOfPoints) {
  const std::string model = "'" PHYNNESS_SAMPLE_MODEL "'";
  ASSERT_EQ(
      phynness("eval " + model + " --point -0.00147,0.00031,0.0222 --displacement 0.001,0,-0.01 --json point.json")
          .exit_status,
      0);
  const auto tool = json("point.json")["tools"][0];
  Json motion = one_tool();
  motion["tools"][0] = {{"nodes", tool["nodes"]}, {"weights", tool["weights"]}};
  motion["time_s"] = {1.0};
  motion["displacement_m"] = Json::array({Json::array({tool["displacement"]})});
  const auto all = answer(motion, model);
  EXPECT_GT(std::abs(all["force_N"][0][0][2].get<double>()), 0.01);
  EXPECT_EQ(all["force_N"][0][0], tool["force"]);
  EXPECT_EQ(all["tools"][0], motion["tools"][0]);
}

TEST_F(Motions, AnsweredAgainHaveNoDifference) {
  auto all = answer(one_tool());
  EXPECT_FALSE(all.contains("recorded"));
  const auto again = answer(all);
  EXPECT_EQ(again["recorded"]["forces"], 3);
  EXPECT_EQ(again["recorded"]["largest_difference_N"], 0.0);
  EXPECT_NE(outcome.out.find("the 3 forces of the file are repeated exactly"), std::string::npos) << outcome.out;
  all["force_N"][1][0][2] = all["force_N"][1][0][2].get<double>() + 0.25;
  const auto other = answer(all);
  EXPECT_NEAR(other["recorded"]["largest_difference_N"].get<double>(), 0.25, 1e-12);
  EXPECT_EQ(other["recorded"]["step"], 1);
  EXPECT_NE(outcome.out.find("0.25 N (step 1)"), std::string::npos) << outcome.out;
}

// A ratio to a force of 0 is infinite: it is left out, and null in JSON.
TEST_F(Motions, WithoutForceHaveNoInfiniteDifference) {
  Json motion = one_tool();
  motion["time_s"] = {0.0};
  motion["displacement_m"] = Json::array({Json::array({{0.0, 0.0, 0.0}})});
  motion["force_N"] = Json::array({Json::array({{0.0, 0.0, 1e300}})});
  const auto all = answer(motion);
  EXPECT_EQ(all["recorded"]["largest_difference_N"], 1e300);
  EXPECT_TRUE(all["recorded"]["of_largest_force"].is_null()) << all["recorded"];
  EXPECT_EQ(outcome.out.find("inf"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("of the largest"), std::string::npos) << outcome.out;
}

TEST_F(Motions, ThatTheModelCannotAnswerAreRefused) {
  Json motion = one_tool();
  motion["tools"][0]["node"] = 100000;
  expect_refused(motion, {"bad.json", "100000"});
  int inactive = 0;
  while (inactive == nodes[0] || inactive == nodes[1]) ++inactive;
  motion["tools"][0]["node"] = inactive;
  expect_refused(motion, {"bad.json, step 0", "node " + std::to_string(inactive), "nearest"});
  // Two nodes that are active, but of no common triangle, and one that the mesh does not have.
  motion["tools"][0] = {{"nodes", nodes}, {"weights", {0.5, 0.5}}};
  expect_refused(motion, {"bad.json: tools[0]", "no triangle", std::to_string(nodes[0])});
  motion["tools"][0] = {{"nodes", {nodes[0], 100000}}, {"weights", {0.5, 0.5}}};
  expect_refused(motion, {"bad.json", "100000"});
  motion = one_tool();
  motion["mesh_hash"] = "00";
  expect_refused(motion, {"bad.json", "mesh_hash 00", "model"});
  motion = one_tool();
  motion["displacement_m"][1][0] = {0.0, 0.0, 2e6};
  expect_refused(motion, {"bad.json: displacement_m[1][0]", "1e6 m", "metres"});
}

TEST_F(Motions, AreNotMixedWithOtherQueries) {
  write_file(folder / "motion.json", one_tool().dump());
  for (const std::string more :
       {"--node 1 --displacement 0,0,0", "--deformation a.csv", "--surface a.vtu", "--point 0,0,0", "--tools paper",
        "--surface a.vtu --subdivide 1", "--queries motion.json"}) {
    const auto refused = be_refused("eval modal --motion motion.json " + more);
    EXPECT_NE(refused.err.find("--motion"), std::string::npos) << refused.err;
  }
  be_refused("eval modal --motion missing.json");
  be_refused("eval modal --motion motion.json --json motion.json");
}

}  // namespace
}  // namespace phynness::test
