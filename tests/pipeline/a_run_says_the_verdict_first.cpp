// Claims about what `run`, `validate` and `calibrate` print: first the verdict, then one table of at most 12 lines, no
// line wider than 100 characters; no row repeats another; the rest with --details, in the JSON and in the report. The
// JSON holds the figures of the verdict, and the node named there is the worst of the drawn probes. A model of patches
// says how far two tools are off.
#include <cmath>

#include "command_line.hpp"

namespace phynness::test {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

void expect_narrow(const std::string& text) {
  for (const auto& line : lines_of(text)) EXPECT_LE(line.size(), 100U) << line;
}

/// From its headings to its last row, whose second cell is a number.
std::vector<std::string> table_of(const std::vector<std::string>& lines) {
  std::size_t begin = 0;
  while (begin < lines.size() && lines[begin].find("force") == std::string::npos) ++begin;
  while (begin + 1 < lines.size() && lines[begin + 1].rfind("to ", 0) != 0) ++begin;
  std::vector<std::string> table;
  for (std::size_t i = begin; i < lines.size() && !lines[i].empty(); ++i) table.push_back(lines[i]);
  return table;
}

bool has_line(const std::vector<std::string>& lines, const std::string& begin) {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.rfind(begin, 0) == 0; });
}

using Verdict = CommandLine;

TEST_F(Verdict, IsFirstAndNarrow) {
  auto scene = small_scene("P1", 3);
  const auto family = scene.find("family = \"rbfn\"");
  scene.replace(family, scene.find("[validation]") - family, "family = \"modal\"\n");
  // Tools between nodes need triangles of active nodes.
  scene.replace(scene.find("active = ["), scene.find("[probe]") - scene.find("active = ["),
                "active = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\n");
  scene.replace(scene.find("0.025"), 5, "0.040");
  scene.replace(scene.find("check_probes = 0"), 16, "check_probes = 2");
  write_file(folder / "scene.toml", scene);
  const auto run = succeed("run scene.toml -o out --json all.json");
  expect_narrow(run.out);
  const auto lines = lines_of(run.out);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.front().rfind("Error of forces: the model is ", 0), 0U) << lines.front();
  for (const char* begin :
       {"Worst node: the force is off by up to ", "Off by more than a tenth", "Out of reach: ", "Left out: "})
    EXPECT_TRUE(has_line(lines, begin)) << begin << "\n" << run.out;
  expect_names(unbroken(run.out), {"from a finer solution (taylor-hood elements on the same mesh) at 2 probes"});
  const auto table = table_of(lines);
  EXPECT_GE(table.size(), 7U) << run.out;
  EXPECT_LE(table.size(), 12U) << run.out;
  // Nothing is flagged, and every row of unflagged probes would repeat one of all.
  EXPECT_FALSE(has_line(lines, "without a warning")) << run.out;
  EXPECT_FALSE(has_line(lines, "unflagged")) << run.out;
  expect_names(run.err, {"== mesh", "== validate"});

  const auto v = json("all.json").at("validate");
  const auto& worst = v.at("verdict").at("worst_node");
  const auto& nodes = v.at("conditions").at("nodes");
  EXPECT_NE(std::find(nodes.begin(), nodes.end(), worst.at("node").get<int>()), nodes.end());
  // The block is 50 mm high and touched on top.
  EXPECT_NEAR(worst.at("z_m").get<double>(), 0.05, 1e-6);
  EXPECT_GE(worst.at("error_N"), worst.at("mean_error_N"));
  EXPECT_EQ(v.at("verdict").at("off_by_a_tenth").at("share"), v.at("all").at("wrong"));
  // The distance of the check is in the model, and from there in the figures of validate and info.
  EXPECT_EQ(v.at("finer"), json("all.json").at("check").at("distance"));
  EXPECT_EQ(v.at("finer").at("element"), "P1");
  EXPECT_GT(v.at("finer").at("p95"), 0.05) << "P1 at K/mu = 10 is too stiff";
  EXPECT_GE(v.at("finer").at("p95"), v.at("finer").at("mean"));
  expect_names(be_refused("train scene.toml out/database.h5 -o other --check out/train.json").err, {"phynness check"});

  // By itself a run solves at least 30 rays for each kind of coupled tools, and both have bounds.
  EXPECT_GE(json("all.json").at("calibrate").at("planned_coupled_rays"), 2 * 30);
  EXPECT_GT(json("all.json").at("calibrate").at("two").at("all").at("coverage"), 0.5);
  // Damaged or foreign distances are refused before training.
  auto check = json("all.json").at("check");
  for (const auto& [key, value] : std::vector<std::pair<const char*, nlohmann::json>>{{"probes", -3},
                                                                                      {"probes", 2.5},
                                                                                      {"probes", 4294967297},
                                                                                      {"mean", -1.0},
                                                                                      {"p95", 1e308},
                                                                                      {"reference", "foo"},
                                                                                      {"element", "a b"}}) {
    auto damaged = check;
    damaged["distance"][key] = value;
    write_file(folder / "damaged.json", damaged.dump());
    expect_names(be_refused("train scene.toml out/database.h5 -o other --check damaged.json").err, {"phynness check"});
  }

  const auto brief = succeed("validate scene.toml out/model --report r.html");
  expect_narrow(brief.out);
  EXPECT_LE(lines_of(brief.out).size(), 24U) << brief.out;  // verdict of at most 11 lines, table, file
  const auto page = read_file(folder / "r.html");
  EXPECT_LT(page.find("[\"Worst node\","), page.find("\"table\":"));
  EXPECT_LT(page.find("\"table\":"), page.find("\"title\":\"Scene\""));
  EXPECT_EQ(page.find("\"unflagged\""), std::string::npos);
  expect_names(page, {"phynness validate SCENE MODEL_DIR --probes 8 --nodes ",
                      "phynness check SCENE --reference taylor-hood --probes 2 "});

  const auto details = succeed("validate scene.toml out/model --details --points 2 --pairs 2");
  expect_narrow(details.out + details.err);
  EXPECT_GT(lines_of(details.out).size(), lines_of(brief.out).size());
  expect_names(details.out, {"zero predictor", "force by finite elements", "runtime on this machine"});
  EXPECT_FALSE(has_line(lines_of(details.out), "unflagged")) << details.out;

  const auto calibrated = succeed("calibrate out/model out/database.h5 -o bounded --rays 200");
  expect_narrow(calibrated.out);
  EXPECT_EQ(calibrated.out.rfind("median bound of the force's error: ", 0), 0U) << calibrated.out;
  const auto checked = std::filesystem::last_write_time(folder / "out/check.json");
  for (const char* other :
       {"run scene.toml -o out --resume --details", "check scene.toml --probes 2 --reference taylor-hood --details",
        "info scene.toml", "info out/model", "info out/database.h5", "calibrate out/model out/database.h5 --details"}) {
    const auto done = succeed(other);
    expect_narrow(done.out + done.err);
    if (std::string(other).starts_with("check")) expect_names(done.out, {"force off by "});
    if (std::string(other) == "info out/model") expect_names(unbroken(done.out), {"from a finer solution"});
  }
  EXPECT_EQ(std::filesystem::last_write_time(folder / "out/check.json"), checked) << "a finished check is kept";
  // One that is damaged, or that was interrupted, is made again.
  for (const char* text : {"{\n  \"element\": \"x\", \"interrupted\": \"no\"}", "{\n  \"element\": \"x\"}"}) {
    write_file(folder / "out/check.json", text);
    succeed("run scene.toml -o out --resume");
    EXPECT_EQ(json("out/check.json").at("distance"), check.at("distance"));
  }
}

}  // namespace
}  // namespace phynness::test
