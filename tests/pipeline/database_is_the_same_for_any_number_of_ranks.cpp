// Claim: probes are solved from rest by any free process, so that 1, 2 and 4 ranks write the same database. The same
// systems are solved in the same order, so that even rounding agrees. Only the solver's tolerance is guaranteed: a
// relative force residual of 1e-8 gives a tolerance of 1e-7 of the largest value for values in float32.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

class Ranks : public CommandLine {
 protected:
  Outcome precompute(int n_ranks, const std::string& options) {
    return shell("mpirun --oversubscribe -n " + std::to_string(n_ranks) + " \"$PHYNNESS\" precompute scene.toml " +
                 options);
  }

  void expect_equal(const std::string& file, const Database& one) {
    const auto other = Database::open(folder / file);
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
};

TEST_F(Ranks, OneTwoAndFourGiveTheSameDatabase) {
  write_file(folder / "scene.toml", small_scene());
  for (const int n : {1, 2, 4}) {
    const auto outcome = precompute(n, "-o database" + std::to_string(n) + ".h5");
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  }
  const auto one = Database::open(folder / "database1.h5");
  ASSERT_EQ(one.header().sets.active.size(), 2u);
  expect_equal("database2.h5", one);
  expect_equal("database4.h5", one);
}

}  // namespace
}  // namespace phynness::test
