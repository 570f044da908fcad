// Claims: `phynness check` compares with the forces of single solves, with Taylor-Hood elements on the same mesh or
// with the same element on the refined mesh, changed as the stiffness at rest changes on finer bodies. Failed solves
// are named, an interruption keeps finished results, and probes that the time does not allow are reported. `--trade`
// gives errors and times of all elements on three meshes against Taylor-Hood elements on the finest, with the forces of
// single solves, and chooses the fastest row within a limit. The tolerance of solves is 1e-8 of the reactions, so that
// forces agree to 1e-5.
#include <cmath>
#include <phynness/formats/model.hpp>
#include <phynness/meshes/meshes.hpp>
#include <regex>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Check : public CommandLine {
 protected:
  static std::string scene(const std::string& element) {
    return changed(small_scene(element), "[probe]\n", "[probe]\nkind = \"patch\"\ntool_radius_m = 0.03\n");
  }

  /// Force of a single solve.
  Eigen::Vector3d force(const std::string& file, const nlohmann::json& probe, double depth_m, int increments) {
    std::ostringstream d;
    d.precision(17);
    for (int k = 0; k < 3; ++k) d << (k ? "," : "") << depth_m * probe.at("direction").at(k).get<double>();
    const auto solved =
        phynness("solve " + file + " --node " + std::to_string(probe.at("node").get<int>()) +
                 " --displacement=" + d.str() + " --json f.json --increments " + std::to_string(increments));
    EXPECT_EQ(solved.exit_status, 0) << solved.err;
    const auto f = json("f.json").at("tools").at(0).at("force");
    return {f.at(0).get<double>(), f.at(1).get<double>(), f.at(2).get<double>()};
  }
};

TEST_F(Check, GivesTheRatiosOfSingleSolves) {
  const auto own = scene("P1");
  write_file(folder / "own.toml", own);
  write_file(folder / "th.toml", changed(own, "\"P1\"", "\"taylor-hood\""));
  const auto from = own.find("shape = "), to = own.find("[material]");
  write_file(folder / "fine.toml", std::string(own).replace(from, to - from, "file = \"fine.msh\"\n"));
  write_msh(refined(make_mesh(read_scene(folder / "own.toml")).mesh), nullptr, folder / "fine.msh");

  for (const auto& [name, file] : {std::pair{"taylor-hood", "th.toml"}, std::pair{"half-size", "fine.toml"}}) {
    const auto outcome = succeed("check own.toml --probes 2 --seconds 300 --json check.json" +
                                 std::string(name[0] == 'h' ? " --reference half-size" : ""));
    EXPECT_NE(outcome.out.find("too large"), std::string::npos) << outcome.out;
    const auto check = json("check.json");
    EXPECT_EQ(check.at("reference"), name);
    ASSERT_EQ(check.at("probes").size(), 2u);
    const auto depths = check.at("depth_m").get<std::vector<double>>();
    ASSERT_EQ(depths.size(), 2u);
    EXPECT_DOUBLE_EQ(depths.back(), 0.008);
    EXPECT_NE(check.at("probes").at(0).at("node"), check.at("probes").at(1).at("node"));
    EXPECT_GT(check.at("probes").at(0).at("inward").get<double>(), 0.7);
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const auto said = check.at("ratios").at(i);
      double sum = 0, largest = 0, error = 0;
      for (const auto& probe : check.at("probes")) {
        const auto own_N = force("own.toml", probe, depths[i], static_cast<int>(i + 1));
        const auto finer_N = force(file, probe, depths[i], static_cast<int>(i + 1));
        const double finest_N = probe.at("finest_force").at(i), ratio = own_N.norm() / finest_N;
        EXPECT_NEAR(probe.at("finer").at("force").at(i).get<double>() / finer_N.norm(), 1, 1e-5);
        error += (own_N - finer_N).norm() / finer_N.norm() / 2;
        sum += ratio;
        largest = std::max(largest, ratio);
      }
      EXPECT_EQ(said.at("n").get<int>(), 2);
      EXPECT_NEAR(said.at("median").get<double>(), sum / 2, 1e-5) << name << i;
      EXPECT_NEAR(said.at("max").get<double>(), largest, 1e-5) << name << i;
      if (i + 1 == depths.size()) {
        if (name[0] == 'h') {
          EXPECT_NEAR(check.at("distance").at("mean").get<double>(), error, 1e-5);
        }
        EXPECT_EQ(check.at("distance").at("nodes"), check.at("nodes"));
        EXPECT_EQ(check.at("distance").at("solved"), 2);
      }
      EXPECT_GT(largest, 1.05) << "P1 at K/mu = 10 is too stiff: this test would show nothing";
    }
  }
}

// At a small displacement the finest forces are those of Taylor-Hood on the refined mesh. The displacement is 0.1 % of
// the body, so that both are linear to about as much.
TEST_F(Check, CountsSmallerCellsAsTheStiffnessAtRest) {
  const auto own = changed(scene("p1-p1"), "0.008", "0.0001");
  write_file(folder / "own.toml", own);
  const auto from = own.find("shape = "), to = own.find("[material]");
  write_file(folder / "fine.toml", changed(std::string(own).replace(from, to - from, "file = \"fine.msh\"\n"),
                                           "\"p1-p1\"", "\"taylor-hood\""));
  write_msh(refined(make_mesh(read_scene(folder / "own.toml")).mesh), nullptr, folder / "fine.msh");
  const auto done = succeed("check own.toml --probes 2 --seconds 300 --json check.json");
  const auto check = json("check.json");
  for (const auto& probe : check.at("probes")) {
    const double finest_N = probe.at("finest_force").back(), finer_N = probe.at("finer").at("force").back();
    EXPECT_NEAR(finest_N / force("fine.toml", probe, 0.0001, 1).norm(), 1, 2e-3);
    EXPECT_GT(std::abs(finest_N / finer_N - 1), 5e-3) << "this test would show nothing";
  }
  const auto& distance = check.at("distance");
  EXPECT_GT(distance.at("element_at_rest").at("mean"), distance.at("cells_at_rest").at("mean"));
  EXPECT_EQ(distance.at("shape_at_rest").at("places"), distance.at("cells_at_rest").at("places"));
  EXPECT_EQ(distance.at("shape_at_rest").at("mean"), 0) << "the surface of a block is that of its mesh";
  EXPECT_LT(distance.at("of_reference").at("mean"), distance.at("mean"));
  // The sizes of two forces differ by at most their difference.
  EXPECT_NE(distance.at("force_ratio").get<double>(), 1);
  EXPECT_LE(std::abs(distance.at("force_ratio").get<double>() - 1), distance.at("mean").get<double>());
  expect_names(unbroken(done.out),
               {"multiplied by the factor by which cells of half the size change the stiffness at rest",
                "With taylor-hood elements on the same mesh, which answer one tool only, the error would"});
  EXPECT_EQ(unbroken(done.out).find("shape of the surface"), std::string::npos) << done.out;
}

// The inside of a cylinder that is meshed with coarse edges is smaller than the cylinder: its shape is a part.
TEST_F(Check, CountsTheShapeThatCoarseEdgesCutOff) {
  auto round = scene("p1-p1");
  const auto from = round.find("shape = "), to = round.find("[material]");
  round.replace(from, to - from, "shape = \"cylinder\"\nradius_m = 0.03\nlength_m = 0.08\ntarget_size_m = 0.022\n");
  write_file(folder / "scene.toml", round);
  succeed("check scene.toml --probes 1 --seconds 300 --json check.json");
  const auto coarse = json("check.json").at("distance").at("shape_at_rest");
  EXPECT_GT(coarse.at("places"), 0);
  EXPECT_GT(coarse.at("mean"), 0.02);

  const auto fixed = round.find("fixed = "), active = round.find("active = ");
  round.replace(
      fixed, active - fixed,
      "fixed = [{ nearest = { point_fraction = [0, 0.5, 0] } }, { nearest = { point_fraction = [1, 0.5, 0] } },"
      " { nearest = { point_fraction = [0.5, 1, 0] } }]\n");
  write_file(folder / "scene.toml", round);
  expect_names(unbroken(succeed("check scene.toml --probes 1 --seconds 300").out),
               {"not compared at rest: shape: ", "fixed nodes of one mesh cannot be found on another one"});
}

// Only solids are compared at rest.
TEST_F(Check, AsksForNoComparisonAtRestOfShells) {
  FinerDistance distance{.is_measured = true, .element = "shell", .reference = "half-size", .probes = 4};
  distance.has_parts = true;
  EXPECT_EQ(distance.sentence().find("Not compared"), std::string::npos) << distance.sentence();
  distance.element = "p1-p1";
  EXPECT_NE(distance.sentence().find("Not compared: the shape of the surface"), std::string::npos);
  for (const auto& [ratio, sign] : {std::pair{0.87, "(forces 13 % too small)"}, {1.02, "(forces 2.0 % too large)"}}) {
    distance.force_ratio = ratio;
    EXPECT_NE(distance.sentence().find(sign), std::string::npos) << distance.sentence();
  }
}

TEST_F(Check, OfNodeProbesHoldsPatchesAndSaysSo) {
  write_file(folder / "scene.toml", small_scene("taylor-hood"));
  const auto outcome = succeed("check scene.toml --probes 1 --seconds 300 --json check.json");
  const auto check = json("check.json");
  EXPECT_TRUE(check.at("patch_for_node").get<bool>());
  EXPECT_DOUBLE_EQ(check.at("tool_edges").get<double>(), 2);
  EXPECT_NE(outcome.err.find("note: "), std::string::npos) << outcome.err;
  // It is its own reference.
  EXPECT_EQ(check.at("reference"), "half-size");
  EXPECT_EQ(check.at("ratios").back().at("n").get<int>(), 1);
  expect_names(be_refused("check scene.toml --reference taylor-hood").err, {"it is the element of the scene"});
}

TEST_F(Check, NamesSolvesThatFail) {
  // The law has no resistance to strong compression: a push to the bottom inverts cells.
  auto deep = changed(scene("P1"), "neo-hookean", "st-venant-kirchhoff");
  deep = changed(changed(deep, "0.008", "0.045"), "increments = 2", "increments = 6");
  write_file(folder / "scene.toml", deep);
  const auto outcome = succeed("check scene.toml --probes 1 --seconds 300 --json check.json");
  const auto probe = json("check.json").at("probes").at(0);
  for (const char* name : {"scene", "finer"}) {
    EXPECT_NE(probe.at(name).at("status").back(), "converged") << name;
    EXPECT_TRUE(probe.at(name).at("force").back().is_null()) << name;
  }
  EXPECT_EQ(json("check.json").at("ratios").back().at("n").get<int>(), 0);
  expect_names(outcome.out, {"failed", "node " + std::to_string(probe.at("node").get<int>())});
}

TEST_F(Check, KeepsWhatIsFinishedWhenInterrupted) {
  // A probe is two rays of some tenths of a second each, and the check does not end before the fourth probe.
  const auto many = changed(with_active(scene("p1-p1"), active_top), "target_size_m = 0.025", "target_size_m = 0.014");
  write_file(folder / "scene.toml", changed(many, "increments = 2", "increments = 6"));
  const auto stopped =
      interrupted("check scene.toml --probes 1000 --seconds 1000 --json part.json", "[2-5]/[0-9]+ rays");
  EXPECT_EQ(stopped.exit_status, 1);
  EXPECT_NE(stopped.err.find("interrupted"), std::string::npos) << stopped.err;
  const auto part = json("part.json");
  EXPECT_TRUE(part.at("interrupted").get<bool>());
  EXPECT_GE(part.at("probes").size(), 1u);
  EXPECT_GE(part.at("ratios").back().at("n").get<int>(), 1);
}

TEST_F(Check, SaysWhatTheTimeDoesNotAllow) {
  write_file(folder / "scene.toml", changed(scene("P1"), "target_size_m = 0.025", "target_size_m = 0.007"));
  const auto outcome = phynness("check scene.toml --reference half-size --seconds 1 --json check.json");
  EXPECT_GT(json("check.json").at("left_out"), 0);
  EXPECT_GT(json("check.json").at("sufficient_seconds").get<double>(), 1);
  EXPECT_TRUE(std::regex_search(outcome.out + outcome.err, std::regex("--seconds [1-9]"))) << outcome.out;
  EXPECT_TRUE(std::regex_search(
      unbroken(outcome.out),
      std::regex("not compared at rest: the size of the cells .*--seconds [1-9][0-9]* would be enough")))
      << outcome.out;
  // Without mpirun and in one process, like plan.
  be_refused("check scene.toml --probes 0");
  be_refused("check scene.toml --seconds nan");
}

TEST_F(Check, TradesErrorForTime) {
  const auto own = scene("p1-p1");
  write_file(folder / "scene.toml", own);
  const auto done = succeed("check scene.toml --trade --probes 2 --seconds 600 --max-error 50% --json trade.json");
  const auto trade = json("trade.json");
  const auto& rows = trade.at("rows");
  ASSERT_EQ(rows.size(), 15u) << "five elements on three meshes";
  const auto row = [&](const std::string& element, std::size_t mesh) {
    for (std::size_t i = 5 * mesh; i < 5 * mesh + 5; ++i)
      if (rows.at(i).at("element") == element) return rows.at(i);
    throw std::runtime_error(element);
  };
  for (const std::size_t mesh : {0, 1, 2}) {
    EXPECT_LT(row("p1-p1", mesh).at("mean"), row("P1", mesh).at("mean")) << "P1 locks";
    EXPECT_EQ(row("p1-p1", mesh).at("is_scene"), mesh == 1);
    if (mesh > 0) {
      EXPECT_GT(row("P1", mesh).at("nodes"), row("P1", mesh - 1).at("nodes"));
      EXPECT_LT(row("P1", mesh).at("mean"), row("P1", mesh - 1).at("mean"));
    }
  }
  EXPECT_TRUE(row("taylor-hood", 2).at("is_reference").get<bool>());
  EXPECT_TRUE(row("taylor-hood", 2).at("mean").is_null());

  // The fastest row within the limit, and what to write into the scene.
  const auto chosen = rows.at(trade.at("chosen").get<std::size_t>());
  EXPECT_LE(chosen.at("mean"), 0.5);
  for (const auto& other : rows)
    if (!other.at("mean").is_null() && other.at("mean") <= 0.5) {
      EXPECT_LE(chosen.at("core_hours"), other.at("core_hours"));
    }
  expect_names(done.out, {"> element = \"" + chosen.at("element").get<std::string>() + "\", target_size_m = "});
  for (const auto& one : rows)
    for (const auto& other : rows)
      if (one.at("on_front") == true && !other.at("mean").is_null()) {
        EXPECT_FALSE(other.at("mean") < one.at("mean") && other.at("core_hours") < one.at("core_hours"));
      }
}

TEST_F(Check, TradesOnAFileAsItCompares) {
  // Tetrahedra of a file are not changed, so that all elements are compared on its nodes.
  const auto own = scene("p1-p1");
  write_file(folder / "own.toml", own);
  write_msh(make_mesh(read_scene(folder / "own.toml")).mesh, nullptr, folder / "own.msh");
  const auto from = own.find("shape = "), to = own.find("[material]");
  write_file(folder / "file.toml", std::string(own).replace(from, to - from, "file = \"own.msh\"\n"));
  succeed("check file.toml --trade --probes 2 --seconds 600 --json trade.json");
  write_file(folder / "th.toml", changed(read_file(folder / "file.toml"), "\"p1-p1\"", "\"taylor-hood\""));
  succeed("check file.toml --reference taylor-hood --probes 2 --seconds 600 --json check.json");
  const auto rows = json("trade.json").at("rows");
  ASSERT_EQ(rows.size(), 5u);
  double error = 0;
  const auto check = json("check.json");
  for (const auto& probe : check.at("probes")) {
    const auto finer_N = force("th.toml", probe, 0.008, 2);
    error += (force("file.toml", probe, 0.008, 2) - finer_N).norm() / finer_N.norm() / 2;
  }
  for (const auto& row : rows)
    if (row.at("is_scene") == true) {
      EXPECT_NEAR(row.at("mean"), error, 1e-5);
    }
}

TEST_F(Check, RefusesATradeThatItCannotMake) {
  write_file(folder / "scene.toml", scene("p1-p1"));
  expect_names(be_refused("check scene.toml --max-error 5%").err, {"--trade"});
  expect_names(be_refused("check scene.toml --trade --max-error 5").err, {"--max-error 5", "5%"});
  expect_names(be_refused("check scene.toml --trade --reference half-size").err, {"--reference"});
  expect_names(be_refused("check " PHYNNESS_SOURCE_DIR "/scenes/penrose_case4.toml --trade").err,
               {"nothing to trade", "shell", "--reference half-size"});
  const auto missed = phynness("check scene.toml --trade --probes 1 --max-error 0.0001%");
  EXPECT_EQ(missed.exit_status, 1);
  expect_names(missed.err, {"meets the limit", "--max-error 0.0001%"});
  write_file(folder / "scene.toml", changed(scene("p1-p1"), "target_size_m = 0.025", "target_size_m = 0.008"));
  expect_names(be_refused("check scene.toml --trade --seconds 2").err,
               {"the finer solution needs more time", "taylor-hood", "--seconds "});
}

}  // namespace
}  // namespace phynness::test
