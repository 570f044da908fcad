// Claim: family modal passes through the pipeline and has smaller errors than the paper's networks and the linear
// predictor for the same probes. tune writes the model that meets the limits, or names the limits that are not met.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class Families : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene("P1", 3));
    make_once({"precompute scene.toml -o d.h5"});
  }
};

TEST_F(Families, ModalIsCloserToTheFiniteElementsThanAnyOther) {
  for (const std::string family : {"modal", "rbfn"}) {
    succeed("train scene.toml d.h5 -o " + family + " --family " + family);
    succeed("validate scene.toml " + family + " --probes 80 --json " + family + ".json");
  }
  const auto modal = json("modal.json"), rbfn = json("rbfn.json");
  for (const char* group : {"inside", "outside"})
    for (const char* what : {"force", "displacement"}) {
      const auto mean = [&](const nlohmann::json& of) { return of.at(group).at(what).at("mean").get<double>(); };
      EXPECT_LT(mean(modal), mean(rbfn)) << group << " " << what;
      EXPECT_LT(mean(modal), 0.5 * mean(modal.at("linear"))) << group << " " << what;
    }
}

TEST_F(Families, EnergyIsTheWorkOfTheForce) {
  succeed("train scene.toml d.h5 -o m --family modal");
  const auto node = std::to_string(active_of("m").at(0));
  succeed("eval m --node " + node + " --displacement 0.002,0,-0.005 --json e.json");
  succeed("solve d.h5 --node " + node + " --displacement 0.002,0,-0.005 --json s.json");
  const double model = json("e.json").at("energy"), solved = json("s.json").at("energy");
  // Trained on forces alone: its energy is the integral of forces that are right to about a percent.
  EXPECT_NEAR(model, solved, 0.02 * solved);
}

TEST_F(Families, ModelsOfForcesAloneSayThatTheyHaveNoDeformation) {
  succeed("train scene.toml d.h5 -o m --family modal --set modes=0");
  const auto tool = " --node " + std::to_string(active_of("m").at(0)) + " --displacement 0,0,-0.005";
  const auto eval = succeed("eval m" + tool + " --json e.json");
  EXPECT_TRUE(json("e.json").at("max_displacement").is_null());
  EXPECT_LT(json("e.json").at("tools").at(0).at("force").at(2).get<double>(), 0);
  expect_names(be_refused("eval m" + tool + " --deformation u.csv").err, {"forces only"});
  succeed("validate scene.toml m --probes 8 --json v.json");
  EXPECT_TRUE(json("v.json").at("inside").at("displacement").at("mean").is_null());
  EXPECT_GT(json("v.json").at("inside").at("force").at("n").get<int>(), 0);
}

TEST_F(Families, TuneMeetsTheLimitsOrSaysWhy) {
  succeed("tune scene.toml d.h5 -o m --max-error 5% --max-time 1s --probes 40 --json t.json");
  const auto report = json("t.json");
  const auto chosen = report.at("chosen").get<std::string>();
  bool found = false;
  for (const auto& model : report.at("models")) {
    EXPECT_GT(model.at("deformation_us").get<double>(), 0);
    if (model.at("name") != chosen) continue;
    found = true;
    EXPECT_LE(model.at("inside").at("force").at("mean").get<double>(), 0.05);
    EXPECT_LE(model.at("inside").at("displacement").at("mean").get<double>(), 0.05);
    succeed("info m --json info.json");
    EXPECT_EQ(json("info.json").at("memory_bytes"), model.at("memory_bytes"));
    EXPECT_EQ(json("info.json").at("family"), model.at("family"));
  }
  EXPECT_TRUE(found);

  const auto missed = phynness("tune scene.toml d.h5 -o n --max-time 0.001us --probes 4");
  EXPECT_EQ(missed.exit_status, 1);
  EXPECT_NE(missed.err.find("deformation"), std::string::npos) << missed.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "n"));
  for (const std::string wrong : {"--max-error -1%", "--max-error much", "--max-time 20"})
    be_refused("tune scene.toml d.h5 -o n --probes 4 " + wrong);
}

TEST_F(Families, FewStatesMakeFewCentersNotWildForces) {
  write_file(folder / "few.toml", small_scene("P1", 1));
  succeed("precompute few.toml -o few.h5");
  succeed("train few.toml few.h5 -o m --family modal");
  succeed("validate few.toml m --probes 40 --json v.json");
  const auto v = json("v.json");
  EXPECT_LT(v.at("inside").at("force").at("mean").get<double>(),
            0.5 * v.at("linear").at("inside").at("force").at("mean").get<double>());
}

}  // namespace
}  // namespace phynness::test
