// Claims: validate --body compares a reduced body at the same states as the model, for any number of ranks, and changes
// nothing else; a body of another scene or a damaged one is refused.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class Bodies : public CommandLine {
 protected:
  /// A block whose top is active, with round tools of one and a half edges.
  static std::string round_tools() {
    auto scene = small_scene("p1-p1", 2);
    const auto active = scene.find("active = [");
    scene.replace(active, scene.find("[probe]") - active,
                  "active = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\n"
                  "output = \"free\"\n");
    scene.replace(scene.find("rbfn"), 4, "modal");
    const auto neurons = scene.find("deformation_neurons");
    scene.erase(neurons, scene.find("[validation]") - neurons);
    scene.insert(scene.find("directions = 26"), "kind = \"patch\"\ntool_radius_m = 0.0375\n");
    return scene;
  }
  /// Figures without times.
  nlohmann::json figures(const std::string& file) const {
    auto all = json(file);
    for (const char* time : {"force_us", "deformation_us", "field_us", "seconds", "solve_ms_per_increment", "commands"})
      all.erase(time);
    return all;
  }
};

TEST_F(Bodies, AreComparedBesideTheModel) {
  write_file(folder / "scene.toml", round_tools());
  succeed("run scene.toml -o out");
  succeed("reduce out/database.h5 -o body.txt --cells 1000000");
  const std::string validate = "validate scene.toml out/model --probes 2 --points 3 --pairs 8 --json ";
  succeed(validate + "without.json");
  const auto done = succeed(validate + "with.json --details --body body.txt");
  expect_names(done.out, {"two tools, reduced body", "the reduced body: 0 unsettled, 0 outside of its trained range"});
  auto with = figures("with.json");
  for (const char* part : {"points", "pairs"}) {
    EXPECT_EQ(with.at(part).at("body_warnings").at("unsettled"), 0);
    EXPECT_EQ(with.at(part).at("body_warnings").at("outside"), 0);
  }
  const auto all = with.at("pairs").at("all");
  EXPECT_EQ(all.at("body").at("force").at("n"), all.at("coupled").at("force").at("n"));
  // Measured: forces of pairs to 0.8 % (the model: 25 %), of points to 0.5 %, displacements of pairs to 0.5 %.
  EXPECT_LT(all.at("body").at("force").at("max"), 0.02);
  EXPECT_LT(all.at("body").at("displacement_all").at("max"), 0.02);
  EXPECT_LT(with.at("points").at("body").at("force").at("max"), 0.02);

  const auto ranks = shell("mpirun --oversubscribe -n 2 \"$PHYNNESS\" " + validate + "ranks.json --body body.txt");
  ASSERT_EQ(ranks.exit_status, 0) << ranks.err;
  EXPECT_EQ(json("ranks.json").at("points"), with.at("points"));
  EXPECT_EQ(json("ranks.json").at("pairs"), with.at("pairs"));

  with.at("points").erase("body");
  for (auto& part : {&with.at("points"), &with.at("pairs")}) part->erase("body_warnings");
  auto& pairs = with.at("pairs");
  pairs.erase("body_by_warning");
  for (auto& group : pairs)
    if (group.is_object()) group.erase("body");
  for (auto& record : pairs.at("records")) record.erase("body"), record.erase("body_flagged");
  EXPECT_EQ(with, figures("without.json"));

  expect_error(be_refused("validate scene.toml out/model --probes 2 --body body.txt").err, {"--points", "--pairs"});
  auto text = read_file(folder / "body.txt");
  const auto at = text.find("physics ") + 8;
  text[at] = text[at] == '0' ? '1' : '0';
  write_file(folder / "body.txt", text);
  expect_error(be_refused(validate + "v.json --body body.txt").err, {"body.txt", "checksum"});
  write_file(folder / "other.toml", std::regex_replace(round_tools(), std::regex("0\\.45"), "0.44"));
  succeed("precompute other.toml -o other.h5");
  succeed("reduce other.h5 -o other.txt");
  expect_error(be_refused(validate + "v.json --body other.txt").err, {"another physics", "other.txt"});
}

}  // namespace
}  // namespace phynness::test
