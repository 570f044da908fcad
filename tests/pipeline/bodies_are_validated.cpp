// Claims: validate --body compares a reduced body at the same states as the model, for any number of ranks, and changes
// nothing else; a body of another scene or a damaged one is refused. calibrate --body adds bounds to the body, the same
// for any number of ranks, and changes nothing else in it and nothing in the model; they hold for the states of
// validate.
#include <phynness/formats/body.hpp>
#include <phynness/formats/hash.hpp>

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

TEST_F(Bodies, GetBounds) {
  write_file(folder / "scene.toml", round_tools());
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o m");
  succeed("reduce d.h5 -o body.txt");
  const auto plain = read_file(folder / "body.txt"), model = read_file(folder / "m" / "model.txt");
  EXPECT_EQ(write_body_text(read_body_text(plain, "body.txt")), plain);
  write_file(folder / "ranks.txt", plain);
  const std::string calibrate = "calibrate m d.h5 --rays 100 --json c.json --body ";
  const auto done = succeed(calibrate + "body.txt");
  expect_names(done.out, {"one tool: ", "two tools: ", "mean bound ", "body with bounds -> body.txt"});
  EXPECT_EQ(json("c.json").at("planned_coupled_rays"), 180);
  EXPECT_FALSE(json("c.json").contains("median_bound_N"));
  for (const char* kind : {"between", "two"})
    EXPECT_NEAR(json("c.json").at(kind).at("all").at("coverage").get<double>(), 0.95, 0.06);
  EXPECT_EQ(read_file(folder / "m" / "model.txt"), model);
  const auto text = read_file(folder / "body.txt");
  auto body = read_body_text(text, "body.txt");
  EXPECT_EQ(write_body_text(body), text);
  EXPECT_EQ(body.bounds.rows(), 2);
  EXPECT_EQ(body.coverage, 0.95);
  body.bounds.resize(0, 4);
  EXPECT_EQ(write_body_text(body), plain);

  std::filesystem::remove(folder / "d.h5.calibration");
  ASSERT_EQ(shell("mpirun --oversubscribe -n 2 \"$PHYNNESS\" " + calibrate + "ranks.txt").exit_status, 0);
  EXPECT_EQ(read_file(folder / "ranks.txt"), text);

  const auto checked =
      succeed("validate scene.toml m --probes 2 --points 20 --pairs 40 --json v.json --details --body body.txt");
  expect_names(checked.out, {" errors of its forces are below their bound"});
  for (const auto& [part, forces] : {std::pair{"points", 20}, {"pairs", 80}}) {
    const auto counts = json("v.json").at(part).at("body_warnings");
    EXPECT_GE(counts.at("bounded").get<int>(), forces) << part;
    EXPECT_GT(counts.at("covered").get<double>(), 0.85 * counts.at("bounded").get<double>()) << part;
  }

  be_refused(calibrate + "body.txt -o other");
  be_refused(calibrate + "body.txt --reference finer");
  write_file(folder / "other.toml", std::regex_replace(round_tools(), std::regex("0\\.45"), "0.44"));
  succeed("precompute other.toml -o other.h5");
  succeed("reduce other.h5 -o other.txt");
  expect_error(be_refused(calibrate + "other.txt").err, {"another physics", "other.txt"});
  const auto damaged = [&](const std::string& from, const std::string& to) {
    auto lines = text.substr(0, text.rfind("checksum "));
    lines.replace(lines.rfind(from), from.size(), to);
    return lines + "checksum " + hash_of(lines) + "\n";
  };
  for (const auto& [from, to, words] : {std::tuple{"\nbounds 2\n", "\nbounds 3\n", "bounds is out of range 2 ... 2"},
                                        {"\nrays ", "\nrays -", "rays is out of range"}}) {
    write_file(folder / "bad.txt", damaged(from, to));
    expect_error(be_refused(calibrate + "bad.txt").err, {words, "bad.txt:"});
    expect_error(be_refused("validate scene.toml m --probes 2 --points 2 --body bad.txt").err, {"bad.txt", "byte"});
  }
}

}  // namespace
}  // namespace phynness::test
