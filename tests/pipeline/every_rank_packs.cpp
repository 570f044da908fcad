// Claims: any number of ranks packs the same logs to the same bytes, also where a log is damaged. What ends a run under
// mpirun is said with the remedy.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

class EveryRankPacks : public CommandLine {
 protected:
  static constexpr int n_logs = 4;

  /// whole.h5, and its rays in the logs of an unfinished database.
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml",
               changed(with_active(small_scene("P1", 12), "active = \"free-surface\"\n"), "0.025", "0.05"));
    make_once({"precompute scene.toml -o whole.h5"});
    const auto whole = Database::open(folder / "whole.h5");
    const auto& header = whole.header();
    const auto n = static_cast<std::int32_t>(header.sets.active.size());
    ASSERT_GT(n, 16) << "too few for a part for each of three ranks";
    DatabaseWriter::create(folder / "logged.h5", header, false);
    std::vector<DatabaseWriter> logs;
    for (int rank = 0; rank < n_logs; ++rank) logs.emplace_back(folder / "logged.h5", header, rank);
    for (std::int32_t active_node = 0; active_node < n; ++active_node)
      for (const auto& ray : whole.rays(active_node))
        logs[static_cast<std::size_t>(ray.direction % n_logs)].append(ray);
    for (auto& log : logs) log.close();
  }

  /// A copy of the unfinished database.
  fs::path copy(const std::string& name) const {
    fs::copy_file(folder / "logged.h5", folder / name);
    fs::copy(folder / "logged.h5.log", folder / (name + ".log"));
    return folder / name;
  }
  Outcome resume(int n_ranks, const std::string& name) const {
    return shell("timeout 120 mpirun --oversubscribe -n " + std::to_string(n_ranks) +
                 " \"$PHYNNESS\" precompute scene.toml --resume -o " + name + " --json " + name + ".json");
  }
};

TEST_F(EveryRankPacks, to_the_same_bytes) {
  for (const int n : {1, 2, 3}) {
    const auto name = "by" + std::to_string(n) + ".h5";
    const auto file = copy(name);
    const auto outcome = resume(n, name);
    ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
    EXPECT_EQ(read_file(file), read_file(folder / "whole.h5")) << n;
    EXPECT_FALSE(fs::exists(file.string() + ".log"));
    // Each rank counts what it packs.
    const auto counted = json(name + ".json"), read = [&] {
      succeed("precompute scene.toml --resume -o whole.h5 --json read.json");
      return json("read.json");
    }();
    for (const char* figure : {"increments", "increments_after_end", "failed", "newton_iterations"})
      EXPECT_EQ(counted.at(figure), read.at(figure)) << figure;
    EXPECT_GT(counted.at("newton_iterations"), 0);
  }
}

TEST_F(EveryRankPacks, what_another_rank_finds_damaged_is_solved_again) {
  const auto log = copy("damaged.h5").string() + ".log/rank-0001";
  auto bytes = read_file(log);
  bytes[bytes.size() / 2] ^= 1;
  write_file(log, bytes);
  const auto outcome = resume(3, "damaged.h5");
  ASSERT_EQ(outcome.exit_status, 0) << outcome.err;
  EXPECT_EQ(json("damaged.h5.json").at("rays_resumed").get<int>() + 1, json("damaged.h5.json").at("rays").get<int>());
  expect_same_results(folder / "damaged.h5", folder / "whole.h5");
}

TEST_F(EveryRankPacks, what_ends_a_run_is_said) {
  for (const char* kill : {"kill -INT $pid", "kill -9 $(pgrep -P $pid phynness | tail -n 1)"}) {
    fs::remove(folder / "killed.h5");
    fs::remove_all(folder / "killed.h5.log");
    const auto outcome = signalled("mpirun --oversubscribe -n 2 \"$PHYNNESS\" precompute scene.toml -o killed.h5",
                                   "[ \"$(cat killed.h5.log/rank-* 2>/dev/null | wc -c)\" -gt 20000 ]", kill);
    EXPECT_NE(outcome.exit_status, 0) << kill << ": it finished before: the scene is too small for this test";
    expect_names(outcome.err, {"finished rays are kept", "--resume"});
  }
}

}  // namespace
}  // namespace phynness::test
