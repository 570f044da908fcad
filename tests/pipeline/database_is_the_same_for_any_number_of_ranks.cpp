// Claim: probes are solved from rest by any free process, so that 1, 2 and 4 ranks write the same database. The same
// systems are solved in the same order, so that even rounding agrees. The scene has a region.
#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

using Ranks = CommandLine;

TEST_F(Ranks, OneTwoAndFourGiveTheSameDatabase) {
  write_file(
      folder / "scene.toml",
      changed(
          small_scene("es-p1-p1"), "[solver]",
          "[[region]]\nname = \"part\"\ncells = { box = { min_fraction = [0.5, 0, 0], max_fraction = [1, 1, 1] } }\n"
          "youngs_modulus_Pa = 16e3\n[solver]"));
  succeed("precompute scene.toml -o one.h5");
  for (const char* n : {"2", "4"}) {
    const auto outcome = shell(std::string("mpirun --oversubscribe -n ") + n +
                               " \"$PHYNNESS\" precompute scene.toml -o several" + n + ".h5");
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    expect_same_results(folder / ("several" + std::string(n) + ".h5"), folder / "one.h5");
  }
}

}  // namespace
}  // namespace phynness::test
