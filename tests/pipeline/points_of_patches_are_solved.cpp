// Claims about tools between nodes in scenes of patches: phynness solve --point and validate --points answer; at a node
// a patch around the point is the node's patch, and between nodes it moves the point itself by the displacement; eval
// and solve refuse the same tools. A part of a validation that cannot be done costs no other part.
#include <cmath>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class PointsOfPatches : public CommandLine {
 protected:
  /// A block whose top is active, with patches of one and a half edges.
  static std::string patch_scene() {
    auto scene = small_scene("P1", 2);
    const auto active = scene.find("active = [");
    scene.replace(active, scene.find("[probe]") - active,
                  "active = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\n");
    scene.replace(scene.find("rbfn"), 4, "modal");
    const auto neurons = scene.find("deformation_neurons");
    scene.erase(neurons, scene.find("[validation]") - neurons);
    scene.insert(scene.find("directions = 26"), "kind = \"patch\"\ntool_radius_m = 0.0375\n");
    return scene;
  }

  /// A mesh of msh 4.1 with x^2 / 0.1 m in place of x.
  static std::string stretched(const std::string& msh) {
    std::istringstream in(msh);
    std::ostringstream out;
    out.precision(17);
    std::string line;
    std::size_t n = 0, to_skip = 0, to_change = 0;
    while (std::getline(in, line)) {
      double x = 0, y = 0, z = 0;
      if (to_skip == 0 && to_change > 0 && std::sscanf(line.c_str(), "%lf %lf %lf", &x, &y, &z) == 3) {
        --to_change;
        out << x * x / 0.1 << ' ' << y << ' ' << z << '\n';
        continue;
      }
      if (to_skip > 0) --to_skip;
      out << line << '\n';
      if (line != "$Nodes") continue;
      std::getline(in, line);  // one block: its number of nodes, below it their tags
      out << line << '\n';
      EXPECT_EQ(std::sscanf(line.c_str(), "1 %zu", &n), 1) << line;
      to_skip = n + 1;
      to_change = n;
    }
    return out.str();
  }

  /// Force, and displacement of the point by the weights of its triangle's corners.
  struct Answer {
    std::vector<double> force, moved;
  };
  Answer answer(const std::string& command) const {
    const auto done = phynness(command + " --json answer.json --deformation answer.csv");
    EXPECT_EQ(done.exit_status, 0) << done.err;
    if (done.exit_status != 0) return {{0, 0, 0}, {0, 0, 0}};
    const auto tool = json("answer.json").at("tools").at(0);
    Answer a{tool.at("force"), {0, 0, 0}};
    if (!tool.contains("weights")) return a;
    std::istringstream rows(read_file(folder / "answer.csv"));
    std::string line;
    std::getline(rows, line);
    while (std::getline(rows, line)) {
      double v[7];
      EXPECT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6),
                7);
      for (int k = 0; k < 3; ++k)
        if (tool.at("nodes").at(k) == static_cast<int>(v[0]))
          for (int c = 0; c < 3; ++c) a.moved[c] += tool.at("weights").at(k).get<double>() * v[4 + c];
    }
    return a;
  }
};

TEST_F(PointsOfPatches, AreSolvedAndValidated) {
  write_file(folder / "scene.toml", patch_scene());
  ASSERT_EQ(phynness("run scene.toml -o out").exit_status, 0);
  const std::string d = " --displacement 0.002,0,-0.006";
  const auto at_corner = answer("solve out/database.h5 --point 0.1,0.08,0.05" + d);
  const auto nodes = json("answer.json").at("tools").at(0);
  int corner = -1;
  for (int k = 0; k < 3; ++k)
    if (nodes.at("weights").at(k) == 1.0) corner = nodes.at("nodes").at(k);
  ASSERT_GE(corner, 0) << nodes;
  const auto node = answer("solve out/database.h5 --node " + std::to_string(corner) + d);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(at_corner.force[k], node.force[k], 1e-9 * std::abs(node.force[2]));

  const std::string between = " --point 0.047,0.043,0.05" + d;
  const auto truth = answer("solve out/database.h5" + between), model = answer("eval out/model" + between);
  const double expected[3] = {0.002, 0, -0.006};
  double off = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(truth.moved[k], expected[k], 1e-9);
    EXPECT_NEAR(model.moved[k], expected[k], 1e-9);
    off += std::pow(truth.force[k] - model.force[k], 2);
    size += std::pow(truth.force[k], 2);
  }
  // Superposed patches of three nodes are not one patch between them; measured: 3 %.
  EXPECT_LT(std::sqrt(off / size), 0.1);

  const auto validated = phynness("validate scene.toml out/model --probes 4 --points 3 --json v.json");
  EXPECT_EQ(validated.exit_status, 0) << validated.err;
  const auto points = json("v.json").at("points");
  EXPECT_EQ(points.at("finished"), 3);
  EXPECT_EQ(points.at("failed"), 0);
  EXPECT_LT(points.at("coupled").at("force").at("mean").get<double>(), 0.1);
}

TEST_F(PointsOfPatches, ThatOverlapAreRefusedByEvalAndSolveAlike) {
  write_file(folder / "scene.toml", patch_scene());
  ASSERT_EQ(phynness("run scene.toml -o out").exit_status, 0);
  const std::string first = " --point 0.02,0.02,0.05 --displacement 0,0,-0.003", second = " --displacement 0,0,-0.002",
                    near = " --point 0.045,0.02,0.05" + second, far = " --point 0.08,0.065,0.05" + second;
  for (const std::string command : {"solve out/database.h5", "eval out/model"}) {
    const auto overlap = phynness(command + first + near);
    EXPECT_EQ(overlap.exit_status, 2) << command << overlap.out;
    expect_error(overlap.err, {"node"});
    EXPECT_EQ(phynness(command + first + far).exit_status, 0) << command;
  }
  const auto paper = phynness("eval out/model --tools paper --node 4 --node 4" + second + second);
  EXPECT_EQ(paper.exit_status, 2);
}

TEST_F(PointsOfPatches, ThatHoldNoNodeAreRefusedByEvalAndSolveAlike) {
  // Cells that are short at one end and long at the other: some patches hold two nodes, so that the model shows their
  // radius, and others hold none between nodes.
  write_file(folder / "even.toml", patch_scene());
  ASSERT_EQ(phynness("mesh even.toml -o even.msh").exit_status, 0);
  write_file(folder / "uneven.msh", stretched(read_file(folder / "even.msh")));
  auto scene = patch_scene();
  const auto shape = scene.find("shape = ");
  scene.replace(shape, scene.find("[material]") - shape, "file = \"uneven.msh\"\n");
  scene.replace(scene.find("0.0375"), 6, "0.01");
  write_file(folder / "scene.toml", scene);
  ASSERT_EQ(phynness("run scene.toml -o out").exit_status, 0);
  int refused = 0, answered = 0;
  for (const char* point : {"0.085,0.03,0.05", "0.015,0.05,0.05", "0.01,0.05,0.05", "0.08,0.06,0.05"}) {
    const auto rest = std::string(" --point ") + point + " --displacement 0,0,-0.003";
    const auto solve = phynness("solve out/database.h5" + rest), eval = phynness("eval out/model" + rest);
    EXPECT_EQ(solve.exit_status, eval.exit_status) << point << "\n" << solve.err << eval.err;
    if (solve.exit_status == 0) {
      ++answered;
    } else {
      ++refused;
      expect_error(eval.err, {"holds no node of its triangle"});
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(answered, 0);
  // validate says why it does not solve them.
  const auto validated = phynness("validate scene.toml out/model --probes 4 --points 12 --details --json v.json");
  EXPECT_EQ(validated.exit_status, 0) << validated.err;
  const auto points = json("v.json").at("points");
  ASSERT_GT(points.at("refused").get<int>(), 0);
  EXPECT_LE(points.at("refused"), points.at("failed"));
  EXPECT_NE(points.at("first_refusal").get<std::string>().find("holds no node"), std::string::npos);
  EXPECT_NE(validated.out.find("holds no node of its triangle"), std::string::npos) << validated.out;
}

TEST_F(PointsOfPatches, APartThatCannotBeDoneCostsNoOther) {
  auto scene = patch_scene();  // two active nodes: no triangle has three, and both are in both patches
  const auto active = scene.find("active = {");
  scene.replace(active, scene.find("[probe]") - active,
                "active = [{ nearest = { point_fraction = [0.4, 0.4, 1.0] }, surface_only = true },\n"
                "          { nearest = { point_fraction = [0.6, 0.6, 1.0] }, surface_only = true }]\n");
  scene.replace(scene.find("0.0375"), 6, "0.09");
  write_file(folder / "scene.toml", scene);
  ASSERT_EQ(phynness("run scene.toml -o out").exit_status, 0);
  const auto validated =
      phynness("validate scene.toml out/model --probes 4 --points 3 --pairs 2 --json v.json --report r.html");
  EXPECT_EQ(validated.exit_status, 2) << validated.err;
  expect_error(validated.err, {"--points"});
  const auto all = json("v.json");
  EXPECT_GT(all.at("inside").at("force").at("n").get<int>(), 0);
  EXPECT_FALSE(all.at("points").at("not_done").get<std::string>().empty());
  EXPECT_FALSE(all.at("pairs").at("not_done").get<std::string>().empty());
  EXPECT_NE(read_file(folder / "r.html").find("--points"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
