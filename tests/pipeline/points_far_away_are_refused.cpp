// Claim: eval and solve refuse a --point that is far from the surface unless --max-distance allows it, and tell a point
// in millimetres from one that is elsewhere.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class PointsFarAway : public CommandLine {};

TEST_F(PointsFarAway, AreRefusedAndUnitsGuessed) {
  auto scene = small_scene("P1", 2);
  const auto active = scene.find("active = [");
  scene.replace(active, scene.find("[probe]") - active,
                "active = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\n");
  scene.replace(scene.find("rbfn"), 4, "modal");
  write_file(folder / "scene.toml", scene);
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o m");
  const std::string d = " --displacement 0,0,-0.002";
  for (const std::string command : {"eval m", "solve d.h5"}) {
    // The block ends at z = 0.05 m, and its box has a diagonal of 0.137 m.
    succeed(command + " --point 0.05,0.04,0.056" + d);
    const auto far = be_refused(command + " --point 0.05,0.04,0.146" + d);
    expect_error(far.err, {"0.05,0.04,0.146", "0.096 m", "--max-distance", "0.05,0.04,0.05"});
    EXPECT_EQ(far.err.find("millimetres"), std::string::npos) << far.err;
    succeed(command + " --point 0.05,0.04,0.146 --max-distance 0.1 --json a.json" + d);
    EXPECT_NEAR(json("a.json").at("tools").at(0).at("distance").get<double>(), 0.096, 1e-9);
    const auto millimetres = be_refused(command + " --point 50,40,51" + d);
    expect_error(millimetres.err, {"millimetres", "--point 0.05,0.04,0.051"});
    const auto centimetres = phynness(command + " --point 5,4,5.1" + d);
    expect_error(centimetres.err, {"centimetres", "--point 0.05,0.04,0.051"});
  }
}

}  // namespace
}  // namespace phynness::test
