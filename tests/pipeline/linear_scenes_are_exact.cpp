// Claim: a linear scene passes through the whole pipeline, and its model agrees with new finite element solves inside
// and outside of the trained depth: forces to 1e-8 (the solver's relative tolerance), displacements to 1e-6 (float32 in
// the database, 6e-8, twice). So does the linear predictor. Scenes that cannot be trained are refused before anything
// is solved.
#include <phynness/formats/model.hpp>
#include <phynness/formats/vtk.hpp>
#include <sstream>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class LinearScenes : public CommandLine {
 protected:
  static std::string linear_scene(const std::string& element = "P1") {
    auto text = changed(small_scene(element, 1), "\"neo-hookean\"", "\"linear\"");
    text = changed(text, "directions = 26", "directions = 3");
    return changed(text, "\"rbfn\"", "\"linear\"");
  }
  /// `run` of the scene, with every node of the top active.
  void run_with_active_top(const std::string& scene) const {
    write_file(folder / "scene.toml", with_active(scene, active_top));
    std::filesystem::remove_all(folder / "out");
    succeed("run scene.toml -o out");
  }
};

TEST_F(LinearScenes, ModelRepeatsTheFiniteElements) {
  for (const char* element : {"P1", "P2", "p1-p1", "es-p1-p1"}) {
    write_file(folder / "scene.toml", linear_scene(element));
    std::filesystem::remove_all(folder / "out");
    const auto run = succeed("run scene.toml -o out");
    expect_names(unbroken(run.out), {"compared with finer ones: not measured (check_probes = 0)"});
    EXPECT_EQ(json("out/train.json").at("family"), "linear");
    EXPECT_LT(json("out/train.json").at("linear").at("energy_residual"), 1e-6);
    const auto validate = json("out/validate.json");
    EXPECT_EQ(validate.at("failed"), 0);
    for (const char* group : {"inside", "outside"})
      for (const auto& errors : {validate.at(group), validate.at("linear").at(group)}) {
        EXPECT_LT(errors.at("force").at("max"), 1e-8) << element;
        EXPECT_LT(errors.at("displacement").at("max"), 1e-6) << element;
        EXPECT_GT(errors.at("displacement").at("n"), 0) << element;
      }
  }
  const auto info = succeed("info out/model --json info.json");
  EXPECT_NE(info.out.find("exact beyond"), std::string::npos) << info.out;
  EXPECT_EQ(json("info.json").at("family"), "linear");
}

// The trained depth is 8 mm. Energy is half the work of the final force, to the rounding of Simpson's sum.
TEST_F(LinearScenes, EvalWarnsOfNothingAtAnyDepth) {
  write_file(folder / "scene.toml", linear_scene());
  make_once({"run scene.toml -o out"});
  const auto node = std::to_string(active_of("out/model").at(0));
  const auto eval = succeed("eval out/model --node " + node + " --displacement 0.3,0,-0.4 --json eval.json");
  EXPECT_EQ(eval.err.find("warning"), std::string::npos) << eval.err;
  const auto result = json("eval.json");
  EXPECT_EQ(result.at("status"), 0);
  for (const auto& out : {eval.out, succeed("train out/database.h5 -o again").out})
    EXPECT_EQ(out.find("bounds"), std::string::npos) << out;
  const auto force = result.at("tools").at(0).at("force").get<std::vector<double>>();
  const double work = 0.3 * force.at(0) - 0.4 * force.at(2);
  EXPECT_NEAR(result.at("energy").get<double>(), work / 2, 1e-12 * work);
}

// Claim: a model answers one round tool; a second one is refused in a sentence that names what answers several.
TEST_F(LinearScenes, SeveralRoundToolsAreRefused) {
  run_with_active_top(changed(linear_scene("p1-p1"), "[probe]\n", "[probe]\nkind = \"patch\"\ntool_radius_m = 0.02\n"));
  const auto active = active_of("out/model");
  std::string two;
  for (const std::size_t i : {0, 1}) two += " --node " + std::to_string(active.at(i)) + " --displacement 0,0,-0.001";
  for (const std::string& command : {"eval out/model" + two, "eval out/model --tools paper" + two,
                                     std::string("validate scene.toml out/model --probes 2 --pairs 2 --json v.json")})
    expect_names(unbroken(be_refused(command).err), {"answers one tool", "--body", "tools = 2", "[probe]", "es-p1-p1"});
  EXPECT_FALSE(std::filesystem::exists(folder / "v.json"));
}

// Claim: tools between nodes and several at once are exact, too: eval --point and two --node repeat the
// constrained solve. (Where probes move midside points with the node, several nodes held at once are another
// problem than their sum: docs/theory.md.) 1e-6: float32 in the database.
TEST_F(LinearScenes, CoupledToolsRepeatTheFiniteElements) {
  for (const char* element : {"P1", "p1-p1", "es-p1-p1"}) {
    run_with_active_top(linear_scene(element));
    for (const std::string tools : {"--point 0.041,0.033,0.05 --displacement 0.002,0.001,-0.004",
                                    "--point 0.021,0.033,0.05 --displacement 0.002,0.001,-0.004 --point "
                                    "0.07,0.05,0.05 --displacement 0,0,0.003"}) {
      const auto eval = succeed("eval out/model " + tools + " --json eval.json --deformation eval.csv");
      const auto solve = succeed("solve scene.toml " + tools + " --json solve.json --deformation solve.csv");
      const auto e = json("eval.json"), s = json("solve.json");
      EXPECT_LT(e.at("residual").get<double>(), 1e-12);
      const double energy = s.at("energy");
      EXPECT_NEAR(e.at("energy").get<double>(), energy, 1e-6 * energy);
      EXPECT_NEAR(e.at("max_displacement").get<double>(), s.at("max_displacement").get<double>(), 1e-8);
      for (std::size_t t = 0; t < e.at("tools").size(); ++t) {
        const auto said = e.at("tools").at(t).at("force").get<std::vector<double>>();
        const auto truth = s.at("tools").at(t).at("force").get<std::vector<double>>();
        double size = 0;
        for (const double f : truth) size = std::max(size, std::abs(f));
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(said[k], truth[k], 1e-6 * size) << element;
        EXPECT_GT(size, 0);
      }
    }
    const std::string validate = "validate scene.toml out/model --probes 2 --points 3 --pairs 5 --json ";
    succeed(validate + "points.json");
    const auto points = json("points.json").at("points");
    EXPECT_EQ(points.at("failed"), 0);
    EXPECT_EQ(points.at("answers").at("unsettled"), 0);
    for (const char* who : {"coupled", "linear"}) {
      EXPECT_LT(points.at(who).at("force").at("max").get<double>(), 1e-6) << element << ' ' << who;
      EXPECT_LT(points.at(who).at("displacement").at("max").get<double>(), 1e-6) << element << ' ' << who;
      EXPECT_EQ(points.at(who).at("force").at("n"), 12);
    }
    const auto pairs = json("points.json").at("pairs");
    EXPECT_EQ(pairs.at("failed"), 0);
    EXPECT_EQ(pairs.at("answers").at("unsettled"), 0);
    EXPECT_EQ(pairs.at("all").at("solved"), 5);
    for (const char* measure : {"force", "displacement"})
      for (const auto& who : {pairs.at("all"), pairs.at("all").at("linear")})
        EXPECT_LT(who.at(measure).at("max").get<double>(), 1e-6) << element;
    on_two_ranks(validate + "ranks.json");
    EXPECT_EQ(json("ranks.json").at("points"), points);
    EXPECT_EQ(json("ranks.json").at("pairs"), pairs);
  }
  be_refused("eval out/model --point 0.041,0.033,0.05 --displacement 0,0,0.001 --tools paper");
  be_refused("eval out/model --point 0.041,0.033 --displacement 0,0,0.001");
  be_refused("eval out/model --point 0.0,0.033,0.0 --displacement 0,0,0.001");
  be_refused("solve scene.toml --point 0.03,0.033,0.0 --displacement 0,0,0.001");
}

// Claim: eval writes the surface with the displacements of its table, and refuses files that it cannot write.
TEST_F(LinearScenes, EvalWritesTheSurface) {
  write_file(folder / "scene.toml", linear_scene());
  make_once({"run scene.toml -o out"});
  const auto node = std::to_string(active_of("out/model").at(0));
  const auto eval = "eval out/model --node " + node + " --displacement 0,0,-0.006 --deformation u.csv";
  succeed(eval + " --surface s.vtu");
  const auto texts = read_model_texts(folder / "out/model");
  const Model model = read_model_text(texts.model, "model.txt");
  const auto text = read_file(folder / "u.csv");
  VtkGrid grid;
  std::vector<Eigen::RowVector3d> moved;
  std::istringstream csv(text.substr(text.find('\n') + 1));
  for (std::string line; std::getline(csv, line);) {
    auto& u = moved.emplace_back();
    ASSERT_EQ(
        std::sscanf(line.c_str(), "%d,%*f,%*f,%*f,%lf,%lf,%lf", &grid.node_numbers.emplace_back(), &u[0], &u[1], &u[2]),
        4);
  }
  grid.node_numbers.insert(grid.node_numbers.end(), model.fixed.begin(), model.fixed.end());
  grid.points = read_mesh_text(texts.mesh, "mesh.txt").nodes(grid.node_numbers, Eigen::all);
  grid.cells = model.surface.unaryExpr([&](std::int32_t node) {
    return static_cast<std::int32_t>(std::ranges::find(grid.node_numbers, node) - grid.node_numbers.begin());
  });
  Eigen::MatrixXd u = Eigen::MatrixXd::Zero(grid.points.rows(), 3);
  for (std::size_t i = 0; i < moved.size(); ++i) u.row(static_cast<Eigen::Index>(i)) = moved[i];
  EXPECT_GT(u.norm(), 0.006);
  EXPECT_EQ(read_file(folder / "s.vtu"), vtu_text(grid, {0, {{"displacement", u}}}));
  for (const char* wrong : {" --surface s.vtk", " --surface out/model/model.txt", " --surface u.csv"})
    EXPECT_NE(phynness(eval + wrong).exit_status, 0) << wrong;
}

TEST_F(LinearScenes, WhatCannotBeTrainedIsRefusedBeforeAnythingIsSolved) {
  write_file(folder / "bent.toml", changed(linear_scene(), "law = \"linear\"", "law = \"neo-hookean\""));
  for (const std::string command : {"run ", "precompute "}) {
    expect_names(be_refused(command + "bent.toml -o out").err, {"bent.toml:21: [training] family"});
    EXPECT_FALSE(std::filesystem::exists(folder / "out/database.h5"));
    EXPECT_FALSE(std::filesystem::is_regular_file(folder / "out"));
  }
}

}  // namespace
}  // namespace phynness::test
