// Claims: shards, each solved by a process or by several ranks, merge exactly to the database of one run. merge names
// missing parts and the command that solves them. Every command recognizes a shard.
#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

using Shards = CommandLine;

TEST_F(Shards, OfProcessesAndRanksMergeToOneRun) {
  write_file(folder / "scene.toml", small_scene());
  succeed("precompute scene.toml -o whole.h5");
  succeed("precompute scene.toml -o database.h5 --shard 0/3");
  const auto ranks = shell(
      "mpirun --oversubscribe -n 2 \"$PHYNNESS\" precompute scene.toml -o database.h5 --shard 2/3 --json "
      "2.json");
  ASSERT_EQ(ranks.exit_status, 0) << ranks.err;
  const auto figures = json("2.json");
  EXPECT_EQ(figures.at("shard"), "2/3");
  ASSERT_EQ(figures.at("per_rank").size(), 2u);
  int rays = 0;
  for (const auto& rank : figures.at("per_rank")) {
    rays += rank.at("rays").get<int>();
    EXPECT_GE(rank.at("idle_seconds").get<double>(), 0);
    // PETSc, dolfinx and a body of a few dozen nodes: less than a MB or more than 10 GB would be another
    // unit.
    EXPECT_GT(rank.at("peak_memory_bytes").get<double>(), 1e6);
    EXPECT_LT(rank.at("peak_memory_bytes").get<double>(), 1e10);
  }
  EXPECT_EQ(rays, figures.at("rays").get<int>());

  const auto early = phynness("merge database.shard-*.h5 -o database.h5 --json merge.json");
  EXPECT_EQ(early.exit_status, 1);
  EXPECT_NE(early.err.find("rays are missing: "), std::string::npos) << early.err;
  EXPECT_NE(early.err.find("phynness precompute SCENE -o database.h5 --shard 1/3 --resume"), std::string::npos)
      << early.err;
  EXPECT_EQ(early.err.find("--shard 0/3"), std::string::npos) << early.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "database.h5"));
  EXPECT_EQ(json("merge.json").at("missing").at(0).at("shard"), "1/3");

  succeed("precompute scene.toml -o database.h5 --shard 1/3 --resume");
  succeed("merge database.shard-*.h5 -o database.h5");
  expect_same_results(folder / "whole.h5", folder / "database.h5");

  const auto info = phynness("info database.shard-1-of-3.h5");
  expect_names(info.out, {"shard 1/3", "phynness merge"});
  const auto train = be_refused("train scene.toml database.shard-1-of-3.h5 -o model");
  EXPECT_NE(train.err.find("phynness merge"), std::string::npos) << train.err;
}

TEST_F(Shards, ThatDoNotExistOrAreTakenAreRefused) {
  write_file(folder / "scene.toml", small_scene());
  for (const char* bad : {"3/3", "-1/3", "1", "1/0", "x/y"}) {
    const auto refused = be_refused(std::string("precompute scene.toml -o database.h5 --shard=") + bad);
    EXPECT_NE(refused.err.find(bad), std::string::npos) << refused.err;
  }
  // More shards than rays: some have nothing to do, and say so by ending well.
  succeed("precompute scene.toml -o database.h5 --shard 99/100");
  const auto again = be_refused("precompute scene.toml -o database.h5 --shard 99/100");
  EXPECT_NE(again.err.find("--resume"), std::string::npos) << again.err;
}

TEST_F(Shards, OfAnotherMaterialAreRefusedWithBothValues) {
  write_file(folder / "scene.toml", small_scene());
  succeed("precompute scene.toml -o database.h5 --shard 0/2");
  auto changed = small_scene();
  changed.replace(changed.find("max_displacement_m = 0.008"), 26, "max_displacement_m = 0.007");
  write_file(folder / "scene.toml", changed);
  succeed("precompute scene.toml -o database.h5 --shard 1/2");
  const auto merged = be_refused("merge database.shard-0-of-2.h5 database.shard-1-of-2.h5 -o database.h5");
  EXPECT_NE(merged.err.find("probe.max_displacement_m: 0.007 in the file, 0.008 in database.shard-0-of-2.h5"),
            std::string::npos)
      << merged.err;
}

}  // namespace
}  // namespace phynness::test
