// Claim: probes are solved from rest by whichever process is free, so 1, 2 and 4 ranks write the same
// database. Tolerance: the same program solves the same systems in the same order, so even rounding agrees;
// the promise is solver tolerance, and 1e-7 of the largest value is what the relative force residual of 1e-8
// leaves on values in float32.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

using Ranks = CommandLine;

TEST_F(Ranks, OneTwoAndFourGiveTheSameDatabase) {
  write_file(folder / "scene.toml", small_scene());
  for (const int n : {1, 2, 4}) {
    const auto file = "database" + std::to_string(n) + ".h5";
    const auto outcome = shell("mpirun --oversubscribe -n " + std::to_string(n) +
                               " \"$PHYNNESS\" precompute scene.toml -o " + file);
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  }
  const auto one = Database::open(folder / "database1.h5");
  ASSERT_EQ(one.header().sets.active.size(), 2u);
  for (const int n : {2, 4}) {
    const auto other = Database::open(folder / ("database" + std::to_string(n) + ".h5"));
    EXPECT_EQ(other.header().mesh_hash, one.header().mesh_hash);
    EXPECT_EQ(other.statuses(), one.statuses());
    for (std::int32_t a = 0; a < 2; ++a) {
      const auto expected = one.rays(a), got = other.rays(a);
      ASSERT_EQ(got.size(), 26u);
      for (std::size_t d = 0; d < 26; ++d) {
        double force_scale = 0, u_scale = 0;
        for (const double f : expected[d].force) force_scale = std::max(force_scale, std::abs(f));
        for (const double u : expected[d].displacement) u_scale = std::max(u_scale, std::abs(u));
        ASSERT_GT(force_scale, 0);
        ASSERT_GT(u_scale, 0);
        for (std::size_t i = 0; i < expected[d].force.size(); ++i)
          EXPECT_NEAR(got[d].force[i], expected[d].force[i], 1e-7 * force_scale);
        for (std::size_t i = 0; i < expected[d].displacement.size(); ++i)
          EXPECT_NEAR(got[d].displacement[i], expected[d].displacement[i], 1e-7 * u_scale);
      }
    }
  }
}

}  // namespace
}  // namespace phynness::test
