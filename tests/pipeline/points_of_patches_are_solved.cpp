// Claims about tools between nodes in scenes of patches: phynness solve --point and validate --points answer; at a node
// a patch around the point is the node's patch; patches may overlap. A part of a validation that cannot be done costs
// no other part.
#include <cmath>
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class PointsOfPatches : public CommandLine {
 protected:
  std::vector<double> force(const std::string& command) const {
    const auto done = succeed(command + " --json answer.json");
    if (done.exit_status != 0) return {0, 0, 0};
    return json("answer.json").at("tools").at(0).at("force");
  }
};

TEST_F(PointsOfPatches, AreSolvedAndValidated) {
  write_file(folder / "scene.toml", patch_scene("P1"));
  succeed("run scene.toml -o out");
  const std::string d = " --displacement 0.002,0,-0.006";
  const auto at_corner = force("solve out/database.h5 --point 0.1,0.08,0.05" + d);
  const auto nodes = json("answer.json").at("tools").at(0);
  int corner = -1;
  for (int k = 0; k < 3; ++k)
    if (nodes.at("weights").at(k) == 1.0) corner = nodes.at("nodes").at(k);
  ASSERT_GE(corner, 0) << nodes;
  const auto node = force("solve out/database.h5 --node " + std::to_string(corner) + d);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(at_corner[k], node[k], 1e-9 * std::abs(node[2]));

  const std::string between = " --point 0.047,0.043,0.05" + d;
  const auto truth = force("solve out/database.h5" + between), model = force("eval out/model" + between);
  double off = 0, size = 0;
  for (int k = 0; k < 3; ++k) {
    off += std::pow(truth[k] - model[k], 2);
    size += std::pow(truth[k], 2);
  }
  // The edges are two thirds of the radius; interpolated energies are then off by a few per cent.
  EXPECT_LT(std::sqrt(off / size), 0.1);

  succeed("validate scene.toml out/model --probes 4 --points 3 --json v.json");
  const auto points = json("v.json").at("points");
  EXPECT_EQ(points.at("finished"), 3);
  EXPECT_EQ(points.at("failed"), 0);
  EXPECT_LT(points.at("coupled").at("force").at("mean").get<double>(), 0.1);
  // Without --points there is one for twelve probes, and one more; beside the probed part all answers have a warning.
  const auto done = succeed("validate scene.toml out/model --probes 24 --nodes 1 --json v.json");
  expect_names(done.out, {"tools between nodes", "at the rim"});
  EXPECT_EQ(json("v.json").at("points").at("finished"), 3);
  const auto rim = json("v.json").at("rim");
  EXPECT_EQ(rim.at("finished"), 2);
  EXPECT_EQ(rim.at("flagged").at("probes"), rim.at("all").at("probes"));
  // A point far from the surface is refused with the nearest one. The block's box has a diagonal of 0.137 m.
  for (const std::string command : {"eval out/model", "solve out/database.h5"}) {
    succeed(command + " --point 0.05,0.04,0.056" + d);
    expect_error(be_refused(command + " --point 0.05,0.04,0.146" + d).err,
                 {"0.05,0.04,0.146", "0.096 m", "metres", "0.05,0.04,0.05"});
    expect_error(be_refused(command + " --point 50,40,51" + d).err, {"metres"});
  }
}

TEST_F(PointsOfPatches, MayOverlapInSolves) {
  write_file(folder / "scene.toml", patch_scene("P1"));
  const std::string first = " --point 0.03,0.03,0.05 --displacement 0,0,-0.003",
                    second = " --point 0.06,0.03,0.05 --displacement 0,0,-0.002";
  succeed("solve scene.toml" + first + second + " --json both.json");
  EXPECT_EQ(json("both.json").at("tools").size(), 2U);
  const auto same = be_refused("solve scene.toml" + first + first);
  expect_error(same.err, {"same place"});
}

TEST_F(PointsOfPatches, APartThatCannotBeDoneCostsNoOther) {
  // Two active nodes: no triangle has three.
  auto scene = with_active(patch_scene("P1"),
                           "active = [{ nearest = { point_fraction = [0.4, 0.4, 1.0] }, surface_only = true },\n"
                           "          { nearest = { point_fraction = [0.6, 0.6, 1.0] }, surface_only = true }]\n");
  scene = changed(scene, "0.0375", "0.09");
  write_file(folder / "scene.toml", scene);
  succeed("run scene.toml -o out");
  const auto validated = phynness("validate scene.toml out/model --probes 4 --points 3 --json v.json --report r.html");
  EXPECT_EQ(validated.exit_status, 2) << validated.err;
  expect_error(validated.err, {"--points"});
  const auto all = json("v.json");
  EXPECT_GT(all.at("inside").at("force").at("n").get<int>(), 0);
  EXPECT_FALSE(all.at("points").at("not_done").get<std::string>().empty());
  EXPECT_NE(read_file(folder / "r.html").find("--points"), std::string::npos);
}

}  // namespace
}  // namespace phynness::test
