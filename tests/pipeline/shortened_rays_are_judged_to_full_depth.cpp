// Claims about `phynness validate`: a model whose trained depths are shortened is judged by the same probes up to the
// scene's R, which then carry a warning where it was shortened, so that errors are divided by no larger forces; in a
// whole model these are the probes inside the trained range; probes that the finite elements do not reach are counted
// with reason and depth; the figures do not depend on the number of ranks. Solves that differ in their intermediate
// steps agree to the tolerance of the solver, 1e-8 of the force; errors are fractions of the largest force, so that
// 1e-6 is two orders above.
#include <phynness/formats/model.hpp>

#include "../model_dir.hpp"
#include "command_line.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

class ShortenedRays : public CommandLine {
 protected:
  /// St. Venant-Kirchhoff bodies fold under compression; 30 mm is more than half of this one.
  static std::string folding_scene() {
    return changed(changed(small_scene("P1", 4), "neo-hookean", "st-venant-kirchhoff"), "0.008", "0.030");
  }
  nlohmann::json validated(const std::string& options, const std::string& before = "") const {
    const auto done = shell(before + "\"$PHYNNESS\" validate scene.toml " + options + " --json v.json");
    EXPECT_EQ(done.exit_status, 0) << done.err;
    return json("v.json");
  }
};

TEST_F(ShortenedRays, AreJudgedToFullDepth) {
  write_file(folder / "scene.toml", small_scene("P1", 3));
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o whole --family modal");
  auto [model, mesh] = read_model_dir(folder / "whole");
  for (auto& node : model.nodes)
    for (std::size_t i = 0; i < node.trained_depth_m.size(); i += 2) node.trained_depth_m[i] *= 0.25;
  write_model_dir(folder / "short", model, mesh);

  // Of fewer than 20 errors p95 is the largest.
  const auto said = [&] { return unbroken(read_file(folder / "stdout.txt")); };
  const auto whole = validated("whole --probes 40 --pairs 6");
  EXPECT_TRUE(std::regex_search(said(), std::regex(" on average, at most [0-9.]+ % in all [1-6] pairs "
                                                   "\\(linear predictor: [0-9.]+ %, at most ")))
      << said();
  const auto cut = validated("short --probes 40 --pairs 6");
  expect_names(said(), {" % of the node's largest force on average, below ",
                        " % in 95 % of 20 probes at 2 of 2 active nodes (linear "});
  EXPECT_EQ(whole.at("all").at("force"), whole.at("inside").at("force"));
  EXPECT_EQ(whole.at("all").at("displacement"), whole.at("inside").at("displacement"));
  EXPECT_EQ(whole.at("beyond").at("probes"), 20);
  EXPECT_EQ(whole.at("unflagged").at("share"), 1.0);
  EXPECT_TRUE(whole.at("unreached").empty());

  for (const char* what : {"force", "displacement"})
    for (const char* of : {"mean", "median", "p95", "max"})
      EXPECT_GT(cut.at("all").at(what).at(of).get<double>(), whole.at("all").at(what).at(of).get<double>() - 1e-6)
          << what << " " << of;
  EXPECT_TRUE(
      std::regex_search(said(), std::regex("size \\([0-9.]+ % of those without a warning, [0-9.]+ % of those with a "
                                           "warning; linear predictor: [0-9.]+ %\\)")))
      << said();
  const long flagged = cut.at("flagged").at("probes"), unflagged = cut.at("unflagged").at("probes");
  EXPECT_EQ(flagged + unflagged, 20);
  EXPECT_GT(flagged, 3);  // half of the directions lost three quarters of their depth
  EXPECT_GT(unflagged, 3);
  EXPECT_EQ(cut.at("by_node").at("nodes").size(), 2U);
  EXPECT_GT(cut.at("pairs").at("flagged").at("probes").get<int>(), 0);

  auto two = validated("short --probes 40", "mpirun --oversubscribe -n 2 ");
  for (const char* group : {"inside", "outside", "all", "unflagged", "flagged", "beyond", "by_node", "unreached"})
    EXPECT_EQ(two.at(group), cut.at(group)) << group;
}

TEST_F(ShortenedRays, ThatNobodyReachesAreCounted) {
  write_file(folder / "scene.toml", folding_scene());
  succeed("precompute scene.toml -o d.h5");
  succeed("train scene.toml d.h5 -o m --family modal");
  const auto v = validated("m --probes 40 --report r.html");
  const auto& unreached = v.at("unreached");
  ASSERT_GT(unreached.size(), 0U);
  EXPECT_EQ(v.at("all").at("probes"), 20);
  EXPECT_EQ(v.at("all").at("solved").get<std::size_t>() + unreached.size(), 20U);
  for (const auto& probe : unreached) {
    EXPECT_LT(probe.at("reached_m").get<double>(), probe.at("depth_m").get<double>()) << probe;
    EXPECT_LE(probe.at("depth_m").get<double>(), 0.030 * (1 + 1e-12)) << probe;
    EXPECT_FALSE(probe.at("reason").get<std::string>().empty());
  }
  // The verdict, its JSON and the report count the same probes.
  const auto count = std::to_string(unreached.size());
  EXPECT_EQ(v.at("verdict").at("not_covered").at("probes").get<std::size_t>(), unreached.size());
  expect_names(unbroken(read_file(folder / "stdout.txt")),
               {"; " + count + " of 20 probes have no finite element solution"});
  expect_names(read_file(folder / "r.html"), {count + " of 20 probes have no finite element solution"});
}

// Sums of some hundred numbers of about 1, in another order.
TEST_F(ShortenedRays, HaveOneShareOfTheProbeVolume) {
  // Folds are between increments, and a hemisphere asks for some of its directions only.
  for (const char* directions : {"26", "\"hemisphere\""}) {
    write_file(folder / "scene.toml",
               changed(folding_scene(), "directions = 26", std::string("directions = ") + directions));
    fs::remove_all(folder / "d.h5.log");
    fs::remove(folder / "d.h5");
    succeed("precompute scene.toml -o d.h5");
    succeed("train scene.toml d.h5 -o m --family modal");
    const double judged = validated("m --probes 4").at("verdict").at("not_covered").at("share_of_volume");
    const auto verdict = unbroken(read_file(folder / "stdout.txt"));
    EXPECT_EQ(verdict.find(", and all that point outward, which have no training") != std::string::npos,
              directions[0] == '"');
    succeed("info d.h5 --json i.json");
    EXPECT_GT(judged, 0.01);
    EXPECT_NEAR(json("i.json").at("ends").at("share_of_volume").get<double>(), judged, 1e-12) << directions;
  }
}

}  // namespace
}  // namespace phynness::test
