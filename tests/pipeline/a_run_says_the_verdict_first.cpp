// Claims about what `run`, `validate` and `calibrate` print: first the verdict, then one table of at most 8 lines, no
// line wider than 100 characters; no row repeats another; the rest is in the JSON and in the report. The
// JSON holds the figures of the verdict, and the node named there is the worst of the drawn probes. A model of patches
// says how far two tools are off.

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
  scene = with_active(scene, active_top);
  scene = changed(changed(scene, "0.025", "0.040"), "check_probes = 0", "check_probes = 2");
  write_file(folder / "scene.toml", scene);
  const auto run = succeed("run scene.toml -o out --json all.json");
  expect_narrow(run.out);
  const auto lines = lines_of(run.out);
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(
      lines.front().rfind("Force error of the model where it was probed, compared with its own finite elements: ", 0),
      0U)
      << lines.front();
  for (const char* begin : {"Force error of these finite elements, compared with finer ones: ",
                            "Largest force error of the model: ", "Not covered: "})
    EXPECT_TRUE(has_line(lines, begin)) << begin << "\n" << run.out;
  expect_names(unbroken(run.out),
               {"at 2 probes of a round tool", " mm radius (fewer than 4 are too few for a mean)",
                "has taylor-hood elements on the same mesh; its force is multiplied by the factor by which ",
                " the stiffness at rest. At rest the element alone changes the stiffness by ",
                "; smaller cells usually reduce the last. ", "limits the accuracy"});
  EXPECT_EQ(run.out.find("Not compared"), std::string::npos) << "a block has no other shape than its mesh";
  const auto table = table_of(lines);
  EXPECT_GE(table.size(), 4U) << run.out;
  EXPECT_LE(table.size(), 8U) << run.out;
  // Nothing is flagged, and every row of unflagged probes would repeat one of all.
  EXPECT_FALSE(has_line(lines, "without a warning")) << run.out;
  EXPECT_FALSE(has_line(lines, "unflagged")) << run.out;
  // No terminal: each stage says at its end how long it took.
  for (const char* title : {"mesh", "precompute", "check", "train", "validate"})
    EXPECT_TRUE(std::regex_search(run.err, std::regex(std::string("== ") + title + "\n(.*\n)*== " + title + ": [0-9]")))
        << title << "\n"
        << run.err;

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

  // By itself a run solves at least 30 rays of tools between nodes, and these have a bound.
  EXPECT_GE(json("all.json").at("calibrate").at("planned_coupled_rays"), 30);
  EXPECT_GT(json("all.json").at("calibrate").at("between").at("all").at("coverage"), 0.5);
  // Damaged or foreign distances are refused before training.
  auto check = json("all.json").at("check");
  for (const auto& [key, value] : {std::pair{"probes", nlohmann::json(-3)}, {"p95", 1e308}, {"element", "a b"}}) {
    auto damaged = check;
    damaged["distance"][key] = value;
    write_file(folder / "damaged.json", damaged.dump());
    expect_names(be_refused("train scene.toml out/database.h5 -o other --check damaged.json").err, {"phynness check"});
  }

  const auto brief = succeed("validate scene.toml out/model --report r.html --json brief.json");
  expect_narrow(brief.out);
  EXPECT_LE(lines_of(brief.out).size(), 24U) << brief.out;  // verdict of at most 11 lines, table, file
  const auto page = read_file(folder / "r.html");
  EXPECT_LT(page.find("<strong>Largest force error of the model</strong>"), page.find("<table"));
  EXPECT_LT(page.find("<table"), page.find("<h2>Errors</h2>"));
  EXPECT_EQ(page.find("unflagged<"), std::string::npos);
  expect_names(page, {"phynness validate SCENE MODEL_DIR --probes 8 --nodes ",
                      "phynness check SCENE --reference taylor-hood --probes 2 "});

  // The commands of report and JSON repeat their figures bit for bit: the same solves in one process.
  const auto commands = json("brief.json").at("commands");
  for (const auto& [key, command] : commands.items()) {
    auto words = command.get<std::string>();
    expect_names(page, {words});
    words = std::regex_replace(words.substr(9), std::regex("SCENE"), "scene.toml");
    succeed(std::regex_replace(words, std::regex("MODEL_DIR"), "out/model") + " --json " + key + ".json");
  }
  for (const char* group : {"inside", "outside", "all", "verdict", "linear"})
    EXPECT_EQ(json("errors.json").at(group), json("brief.json").at(group)) << group;
  EXPECT_EQ(json("distance.json").at("distance"), json("brief.json").at("finer"));

  const auto more = succeed("validate scene.toml out/model --points 2 --pairs 2 --report r.html");
  expect_narrow(more.out + more.err);
  expect_names(read_file(folder / "r.html"),
               {"zero: mean", "finite elements, ", "2 pairs of tools", "runtime on this machine"});

  const auto calibrated = succeed("calibrate out/model out/database.h5 -o bounded --rays 200");
  expect_narrow(calibrated.out);
  EXPECT_EQ(calibrated.out.rfind("median, over all solved states, of the bound of the force's error: ", 0), 0U)
      << calibrated.out;
  const auto checked = std::filesystem::last_write_time(folder / "out/check.json");
  for (const char* other :
       {"run scene.toml -o out --resume", "check scene.toml --probes 2 --reference taylor-hood", "info scene.toml",
        "info out/model", "info out/database.h5", "calibrate out/model out/database.h5"}) {
    const auto done = succeed(other);
    expect_narrow(done.out + done.err);
    if (std::string(other) == "info out/model")
      expect_names(unbroken(done.out), {"elements  P1; shear modulus at rest 689.655 Pa", " on average (forces ",
                                        " too large), at most ", "2 probes", "Its mesh has "});
  }
  EXPECT_EQ(std::filesystem::last_write_time(folder / "out/check.json"), checked) << "a finished check is kept";
  // One that is damaged, or that was interrupted, is made again.
  for (const char* text : {"{\n  \"element\": \"x\", \"interrupted\": \"no\"}", "{\n  \"element\": \"x\"}"}) {
    write_file(folder / "out/check.json", text);
    succeed("run scene.toml -o out --resume");
    EXPECT_EQ(json("out/check.json").at("distance"), check.at("distance"));
  }
}

std::string without_distance(const std::string& text) {
  return std::regex_replace(
      text, std::regex("(finer [^\n]*\nparts [^\n]*(\n[0-9]+ [^\n]*){6}\nforce_ratio [^\n]*|checksum [^\n]*)\n"), "");
}

// A model holds what was solved and how far that is from a finer solution, and so does its image. Models and images of
// before say that it is not recorded.
TEST_F(Verdict, KnowsItsProvenance) {
  write_file(folder / "scene.toml", small_scene("P1"));
  for (const char* stage : {"mesh scene.toml -o m.msh", "precompute scene.toml --mesh m.msh -o d.h5",
                            "check scene.toml --probes 2 --reference taylor-hood --json check.json",
                            "train scene.toml d.h5 -o at_once --check check.json", "train scene.toml d.h5 -o later"})
    succeed(stage);
  const auto plain = read_file(folder / "later/model.txt");
  expect_names(unbroken(succeed("info later").out), {"distance  from a finer solution: not recorded"});
  const auto with = read_file(folder / "at_once/model.txt");
  EXPECT_NE(with, plain);
  EXPECT_EQ(without_distance(with), without_distance(plain));

  succeed("export at_once -o image --float");
  succeed("info image/model.bin --json image.json");
  succeed("info at_once --json model.json");
  auto said = json("model.json").at("provenance");
  EXPECT_EQ(json("image.json").at("provenance"), said);
  EXPECT_EQ(said.at("mesh_hash"), json("check.json").at("mesh_hash"));
  EXPECT_EQ(said.at("physics_hash"), json("check.json").at("physics_hash"));
  EXPECT_EQ(said.at("element"), "P1");
  EXPECT_DOUBLE_EQ(said.at("shear_modulus_Pa").get<double>(), 2000 / (2 * 1.45));
  EXPECT_EQ(said.at("finer_nodes"), json("check.json").at("nodes"));
  for (const char* key : {"mean", "p95", "probes", "tool_radius_m"})
    EXPECT_EQ(said.at(std::string("finer_") + key), json("check.json").at("distance").at(key)) << key;

  expect_names(succeed("info d.h5 --failed").out, {"no ray stops short"});

  // What was not compared is null, and what an older check has not is not recorded.
  auto check = json("check.json");
  for (const char* key :
       {"near_fixed", "elsewhere", "element_at_rest", "cells_at_rest", "shape_at_rest", "of_reference"})
    EXPECT_EQ(check.at("distance").at(key).at("mean").is_null(), check.at("distance").at(key).at("places") == 0) << key;
  check.at("distance").at("shape_at_rest") = {{"places", 0}, {"mean", nullptr}, {"p95", nullptr}};
  check.at("distance").erase("force_ratio");
  write_file(folder / "older.json", check.dump());
  succeed("train scene.toml d.h5 -o older --check older.json");
  EXPECT_EQ(read_file(folder / "older/model.txt").find("force_ratio"), std::string::npos);

  check.at("distance").at("mean") = nullptr;
  write_file(folder / "null.json", check.dump());
  expect_names(be_refused("train scene.toml d.h5 -o refused --check null.json").err,
               {"null.json", "mean or p95 is null"});
  check.at("distance").erase("probes");
  write_file(folder / "lacking.json", check.dump());
  const auto lacking = be_refused("train scene.toml d.h5 -o refused --check lacking.json").err;
  expect_names(lacking, {"lacking.json: key 'probes' not found"});

  write_file(folder / "image/model.bin", read_file(folder / "image/model.bin").substr(0, 500));
  expect_names(be_refused("info image/model.bin").err, {"image is refused", "phynness export"});

  const std::string sample = PHYNNESS_SOURCE_DIR "/examples/model";
  const auto before = succeed("info " + sample + " --json sample.json");
  expect_names(before.out, {"elements  not recorded; shear modulus at rest not recorded", "distance  from a finer"});
  for (const char* key : {"element", "shear_modulus_Pa", "reference", "finer_mean", "finer_probes"})
    EXPECT_TRUE(json("sample.json").at("provenance").at(key).is_null()) << key;
}

}  // namespace
}  // namespace phynness::test
