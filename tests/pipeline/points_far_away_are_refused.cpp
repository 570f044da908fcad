// Claim: eval and solve refuse a --point that is far from the surface, and name the nearest point of the surface.
#include "command_line.hpp"

namespace phynness::test {
namespace {

class PointsFarAway : public CommandLine {};

TEST_F(PointsFarAway, AreRefused) {
  write_file(folder / "scene.toml", changed(with_active(small_scene("P1", 2), active_top), "rbfn", "modal"));
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o m");
  const std::string d = " --displacement 0,0,-0.002";
  for (const std::string command : {"eval m", "solve d.h5"}) {
    // The block ends at z = 0.05 m, and its box has a diagonal of 0.137 m.
    succeed(command + " --point 0.05,0.04,0.056" + d);
    const auto far = be_refused(command + " --point 0.05,0.04,0.146" + d);
    expect_error(far.err, {"0.05,0.04,0.146", "0.096 m", "metres", "0.05,0.04,0.05"});
    expect_error(be_refused(command + " --point 50,40,51" + d).err, {"metres"});
  }
}

}  // namespace
}  // namespace phynness::test
