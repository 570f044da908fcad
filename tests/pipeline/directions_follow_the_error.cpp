// Claims: with [probe] target_error a node whose predicted error is small has the 14 directions and another one all of
// the 26, and so has a node where a ray ends early. The rays are those of a scene without it, bit for bit, on any
// number of ranks and after a kill; either scene takes those of the other. A model knows the depth of the directions
// that were left out. The plan tells about how many these are.
#include <algorithm>
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class TargetError : public CommandLine {
 protected:
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }
  /// One node in the middle of the top, one at a corner of it.
  static std::string scene(const std::string& target = "", int increments = 3) {
    auto text = changed(small_scene("P1", increments), "0.3, 0.4", "0.5, 0.5");
    text = changed(changed(text, "0.7, 0.6", "0.0, 0.0"), "\"rbfn\"", "\"modal\"\nmodes = 4");
    return target.empty() ? text : changed(text, "increments", "target_error = " + target + "\nincrements");
  }
  static bool is_left_out(const Ray& ray) { return ray.status.front() == Status::not_requested; }
  static int left_out(const Database& database, std::int32_t active) {
    const auto rays = database.rays(active);
    return static_cast<int>(std::ranges::count_if(rays, is_left_out));
  }
  /// A target between the predicted errors of the two nodes.
  std::string between_nodes() {
    write_file(folder / "loose.toml", scene("1"));
    succeed("precompute loose.toml -o loose.h5 --json loose.json");
    const auto said = json("loose.json");
    EXPECT_EQ(said.at("rays_left_out"), 24);
    EXPECT_EQ(said.at("nodes_refined"), 0);
    EXPECT_EQ(said.at("increments_of_run"), 2 * 14 * 3);
    return std::to_string(said.at("predicted_error").at("mean").get<double>());
  }
};

TEST_F(TargetError, LeavesDirectionsOutWhereTheErrorIsSmall) {
  const auto target = between_nodes();
  write_file(folder / "fixed.toml", scene());
  write_file(folder / "scene.toml", scene(target));
  succeed("precompute fixed.toml -o fixed.h5");
  const auto said = succeed("precompute scene.toml -o some.h5 --json some.json");
  expect_names(unbroken(said.err), {"target_error leaves 12 rays out", "1 of 2 nodes have more than 14 directions"});
  EXPECT_EQ(json("some.json").at("rays_left_out"), 12);
  const auto some = Database::open(folder / "some.h5"), fixed = Database::open(folder / "fixed.h5");
  EXPECT_EQ(left_out(some, 0) + left_out(some, 1), 12);
  std::int32_t easy = 0;
  for (std::int32_t active = 0; active < 2; ++active) {
    if (left_out(some, active) == 12) easy = active;
    const auto here = some.rays(active), there = fixed.rays(active);
    for (std::size_t d = 0; d < here.size(); ++d) {
      if (is_left_out(here[d])) continue;
      EXPECT_EQ(here[d].force, there[d].force) << d;
      EXPECT_EQ(here[d].displacement, there[d].displacement) << d;
    }
  }
  const auto parallel =
      shell("mpirun --oversubscribe -n 3 \"$PHYNNESS\" precompute scene.toml -o parallel.h5 --json parallel.json");
  ASSERT_EQ(parallel.exit_status, 0) << parallel.err;
  expect_same_results(folder / "parallel.h5", folder / "some.h5");
  EXPECT_EQ(json("parallel.json").at("predicted_error"), json("some.json").at("predicted_error"));

  // Direction 6 is a diagonal of an edge, which was left out.
  succeed("train scene.toml some.h5 -o model");
  write_file(folder / "q.csv", "node,ux_m,uy_m,uz_m\n" +
                                   std::to_string(some.header().sets.active.at(static_cast<std::size_t>(easy))) +
                                   ",-0.004,-0.004,0\n");
  EXPECT_TRUE(is_left_out(some.rays(easy).at(6)));
  expect_names(succeed("eval model --queries q.csv").out, {",0,0.008"});
}

TEST_F(TargetError, SharesRaysWithOtherScenes) {
  write_file(folder / "scene.toml", scene(between_nodes()));
  write_file(folder / "fixed.toml", scene());
  succeed("precompute scene.toml -o some.h5");
  succeed("precompute fixed.toml -o fixed.h5 --from some.h5 --json fixed.json");
  EXPECT_EQ(json("fixed.json").at("rays_taken"), 40);
  EXPECT_EQ(json("fixed.json").at("increments_of_run"), 12 * 3);
  succeed("precompute fixed.toml -o fresh.h5");
  expect_same_results(folder / "fixed.h5", folder / "fresh.h5");
  succeed("precompute scene.toml -o taken.h5 --from fixed.h5 --json taken.json");
  EXPECT_EQ(json("taken.json").at("increments_of_run"), 0);

  expect_names(be_refused("precompute fixed.toml -o some.h5 --resume").err, {"target_error", "none now", "--from"});
  expect_names(be_refused("precompute scene.toml -o some.h5 --shard 0/2").err, {"target_error", "--shard"});
}

TEST_F(TargetError, SolvesAllDirectionsWhereARayEndsEarly) {
  // Rays that compress a cell to nine tenths end early, and no predicted error exceeds the target.
  const auto limited = [](const std::string& text) {
    return changed(text, "max_disp", "min_jacobian = 0.9\nmax_disp");
  };
  write_file(folder / "scene.toml", limited(scene("1")));
  succeed("precompute scene.toml -o some.h5");
  const auto some = Database::open(folder / "some.h5");
  int refined = 0;
  for (std::int32_t active = 0; active < 2; ++active) {
    const auto rays = some.rays(active);
    const bool early = std::ranges::any_of(rays, [](const Ray& ray) { return ray.end.is_early(); });
    EXPECT_EQ(left_out(some, active), early ? 0 : 12);
    refined += early;
  }
  EXPECT_GT(refined, 0);
}

TEST_F(TargetError, GoesOnAfterAKill) {
  write_file(folder / "scene.toml", scene(between_nodes(), 12));
  succeed("precompute scene.toml -o fresh.h5");
  const auto killed = shell(
      "\"$PHYNNESS\" precompute scene.toml -o some.h5 & pid=$!; for i in $(seq 3000); do "
      "  size=$(cat some.h5.log/rank-0000 2>/dev/null | wc -c); [ \"$size\" -gt 100000 ] && break; "
      "  sleep 0.01; done; kill -KILL $pid; wait $pid");
  ASSERT_NE(killed.exit_status, 0) << "it finished before the signal came: the scene is too small for this test";
  succeed("precompute scene.toml -o some.h5 --resume --json resumed.json");
  EXPECT_GT(json("resumed.json").at("rays_resumed"), 0);
  expect_same_results(folder / "some.h5", folder / "fresh.h5");
}

TEST_F(TargetError, IsPlanned) {
  write_file(folder / "loose.toml", scene("1"));
  write_file(folder / "tight.toml", scene("1e-9"));
  const auto loose = succeed("plan loose.toml --json loose.json"), tight = succeed("plan tight.toml --json tight.json");
  expect_names(loose.out, {"left out  about 24 more", "100 % of the nodes"});
  EXPECT_EQ(json("loose.json").at("rays_requested"), 28);
  EXPECT_EQ(json("tight.json").at("rays_requested"), 52);
  EXPECT_GT(json("tight.json").at("measured").at("predicted_error"), 0);
}

}  // namespace
}  // namespace phynness::test
