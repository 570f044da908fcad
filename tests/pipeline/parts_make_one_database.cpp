// Claims: parts, each solved by a process or by several ranks at the same time, and what a part has left, are packed by
// a run without a part to the database of one run. A finished database grows by parts as well.
#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

using Parts = CommandLine;

TEST_F(Parts, OfProcessesAndRanksMakeTheDatabaseOfOneRun) {
  write_file(folder / "scene.toml", small_scene());
  make_once({"precompute scene.toml -o whole.h5"});
  const auto parts = shell(
      "\"$PHYNNESS\" precompute scene.toml -o database.h5 --part 0/3 --json 0.json & first=$!; "
      "mpirun --oversubscribe -n 2 \"$PHYNNESS\" precompute scene.toml -o database.h5 --part 2/3 --json 2.json; "
      "status=$?; wait $first && exit $status");
  ASSERT_EQ(parts.exit_status, 0) << parts.err;
  EXPECT_EQ(json("2.json").at("part"), "2/3");
  const auto solved = json("0.json").at("rays").get<int>() + json("2.json").at("rays").get<int>();
  EXPECT_NEAR(solved, 2 * 52 / 3.0, 2);
  expect_names(phynness("info database.h5").out, {"unfinished database: " + std::to_string(solved) + " of 52 rays"});
  expect_names(be_refused("train scene.toml database.h5 -o model").err, {"is unfinished", "--resume"});
  succeed("precompute scene.toml -o database.h5 --resume --json last.json");
  EXPECT_EQ(json("last.json").at("rays_resumed"), solved);
  EXPECT_EQ(json("last.json").at("rays"), 52);
  expect_same_results(folder / "whole.h5", folder / "database.h5");
  EXPECT_FALSE(std::filesystem::exists(folder / "database.h5.log"));
  succeed("precompute scene.toml -o database.h5 --part 1/3");  // a task that comes late has nothing to do
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(Parts, ContinueAFinishedDatabase) {
  write_file(folder / "scene.toml", small_scene());
  make_once({"precompute scene.toml -o whole.h5"});
  write_file(folder / "fewer.toml", changed(small_scene(), "directions = 26", "directions = 14"));
  succeed("precompute fewer.toml -o database.h5");
  for (const char* part : {"0/2", "1/2"}) {
    succeed(std::string("precompute scene.toml -o database.h5 --part ") + part + " --json part.json");
    EXPECT_EQ(json("part.json").at("rays_taken"), 14);
  }
  succeed("precompute scene.toml -o database.h5 --resume --json last.json");
  EXPECT_EQ(json("last.json").at("increments_of_run"), 0);
  expect_same_results(folder / "whole.h5", folder / "database.h5");
}

TEST_F(Parts, ThatDoNotExistAreRefused) {
  write_file(folder / "scene.toml", small_scene());
  for (const char* bad : {"3/3", "-1/3", "1", "1/0", "x/y", "1/3x"})
    expect_names(be_refused(std::string("precompute scene.toml -o database.h5 --part=") + bad).err, {bad});
  // More parts than rays: some have nothing to do, and say so by ending well.
  succeed("precompute scene.toml -o database.h5 --part 99/100");
}

}  // namespace
}  // namespace phynness::test
