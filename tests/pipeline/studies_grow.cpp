// Claims: --resume of a database, finished or not, of some of the scene's active nodes and directions or to a smaller
// depth solves only the rays that it does not have, and the new database, by any number of ranks, is the one of which
// all are solved. Spread points keep those that are there. A killed growth keeps the earlier database and goes on. A
// scene with fewer nodes is refused.
#include <algorithm>
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

class Growth : public CommandLine {
 protected:
  /// The scene of the tests with `n` of four active nodes.
  static std::string scene(int n, int increments = 2) {
    std::string active = "active = [";
    for (const char* at : {"0.3, 0.4", "0.7, 0.6", "0.1, 0.9", "0.9, 0.1"})
      if (n-- > 0) active += "{ nearest = { point_fraction = [" + std::string(at) + ", 1.0] }, surface_only = true }, ";
    return with_active(small_scene("P1", increments), active + "]\n");
  }
  /// The same with the displacement of the top only.
  static std::string top_of(const std::string& text) {
    return changed(
        text, "active",
        "output = { plane = { point_fraction = [0, 0, 1], normal = [0, 0, 1], tolerance_m = 1e-6 } }\nactive");
  }
  void expect_fresh(const std::string& file, const std::string& scene_name, double rounding = 0) {
    std::filesystem::remove(folder / "fresh.h5");
    succeed("precompute " + scene_name + " -o fresh.h5");
    expect_same_results(folder / file, folder / "fresh.h5", rounding);
  }
  /// Increments of 1/128 m into a nearly incompressible block 60 mm high, which folds between 40 and 50 mm.
  static std::string deep_scene(int increments) {
    auto text = changed(changed(scene(2, increments), "\"P1\"", "\"p1-p1\""), "0.45", "0.4975");
    text = changed(changed(text, "[0.1, 0.08, 0.05]", "[0.09, 0.06, 0.06]"), "0.025", "0.02");
    text = changed(text, "0.7, 0.6", "0.1, 0.9");
    text = changed(text, "family = \"rbfn\"", "family = \"modal\"");
    text = changed(text, "[training]", "[database]\nfields = [\"von-mises-stress\"]\n[training]");
    return changed(text, "0.008", std::to_string(increments / 128.0) + "\nmin_jacobian = 0");
  }
};

TEST_F(Growth, ToALargerDepthKeepsTheRaysThatEndBefore) {
  write_file(folder / "deep.toml", deep_scene(8));
  write_file(folder / "shallow.toml", deep_scene(6));
  succeed("precompute shallow.toml -o grown.h5");
  const auto ends = Database::open(folder / "grown.h5").ends();
  const auto early = std::count_if(ends.begin(), ends.end(), [](const auto& end) { return end.is_early(); });
  EXPECT_GT(early, 0);
  const auto grown = on_two_ranks("precompute deep.toml -o grown.h5 --resume --json deep.json");
  EXPECT_EQ(json("deep.json").at("rays_taken"), early);
  expect_names(unbroken(grown.out), {std::to_string(early) + " taken from grown.h5"});
  expect_fresh("grown.h5", "deep.toml");
  // The other way round increments would be lost.
  expect_names(be_refused("precompute shallow.toml -o grown.h5 --resume").err,
               {"8 to 0.0625 m in the file, 6 to 0.046875 m now", "increments = 8 and max_displacement_m = 0.0625"});
}

TEST_F(Growth, SolvesOnlyWhatIsMissing) {
  write_file(folder / "two.toml", changed(scene(2), "directions = 26", "directions = 14"));
  write_file(folder / "four.toml", scene(4));
  succeed("precompute two.toml -o grown.h5");
  on_two_ranks("precompute four.toml -o grown.h5 --resume --json four.json");
  EXPECT_EQ(json("four.json").at("rays_taken"), 28);
  EXPECT_EQ(json("four.json").at("rays"), 104);
  expect_fresh("grown.h5", "four.toml");
  // Of fewer nodes the others would be lost.
  const auto before = read_file(folder / "grown.h5");
  write_file(folder / "less.toml", top_of(scene(1)));
  expect_names(be_refused("precompute less.toml -o grown.h5 --resume").err, {"other active nodes", "would be lost"});

  write_file(folder / "other.toml", changed(scene(4), "poisson_ratio = 0.45", "poisson_ratio = 0.4"));
  expect_names(be_refused("precompute other.toml -o grown.h5 --resume").err, {"material."});
  write_file(folder / "other.toml", changed(scene(4), "max_displacement_m = 0.008", "max_displacement_m = 0.01"));
  expect_names(be_refused("precompute other.toml -o grown.h5 --resume").err, {"probe.max_displacement_m"});
  EXPECT_EQ(read_file(folder / "grown.h5"), before);
}

TEST_F(Growth, ContinuesAnUnfinishedDatabaseToMoreNodes) {
  write_file(folder / "two.toml", scene(2, 6));
  write_file(folder / "four.toml", scene(4, 6));
  killed("precompute two.toml -o organ.h5", "organ.h5.log/rank-0000");
  succeed("precompute four.toml -o organ.h5 --resume --json four.json");
  EXPECT_GT(json("four.json").at("rays_taken"), 0);
  EXPECT_LT(json("four.json").at("rays_taken"), 52);
  expect_fresh("organ.h5", "four.toml");
  for (const char* left : {"organ.h5.grown", "organ.h5.grown.log", "organ.h5.log"})
    EXPECT_FALSE(std::filesystem::exists(folder / left)) << left;
}

TEST_F(Growth, KeepsSpreadPoints) {
  const auto spread = [](const char* active) {
    return with_active(small_scene("P1", 1), std::string("active = ") + active + "\n");
  };
  const char* const small =
      "{ spacing_m = 0.03, within = { sphere = { center_fraction = [0.3, 0.5, 1.0], radius_m = 0.03 } } }";
  const char* const large =
      "{ spacing_m = 0.02, within = { sphere = { center_fraction = [0.4, 0.5, 1.0], radius_m = 0.045 } } }";
  write_file(folder / "small.toml", spread(small));
  write_file(folder / "large.toml", spread(large));
  succeed("precompute small.toml -o grown.h5");
  const auto old = Database::open(folder / "grown.h5").header().sets.active;
  succeed("precompute large.toml -o grown.h5 --resume --json large.json");
  const auto now = Database::open(folder / "grown.h5").header().sets.active;
  EXPECT_GT(now.size(), old.size());
  EXPECT_TRUE(std::includes(now.begin(), now.end(), old.begin(), old.end()));
  EXPECT_EQ(json("large.json").at("rays_taken"), 26 * old.size());
  // The scene now means these points.
  const auto before = read_file(folder / "grown.h5");
  succeed("precompute large.toml -o grown.h5 --resume --json again.json");
  EXPECT_EQ(json("again.json").at("increments_of_run"), 0);
  EXPECT_EQ(read_file(folder / "grown.h5"), before);
}

TEST_F(Growth, GoesOnAfterAKill) {
  write_file(folder / "one.toml", scene(1, 6));
  write_file(folder / "four.toml", scene(4, 6));
  succeed("precompute one.toml -o organ.h5");
  const auto before = read_file(folder / "organ.h5");
  // The first log has the rays that were taken, the second those that are solved.
  killed("precompute four.toml -o organ.h5 --resume", "organ.h5.grown.log/rank-0000-1");
  EXPECT_EQ(read_file(folder / "organ.h5"), before);
  succeed("precompute four.toml -o organ.h5 --resume --json resumed.json");
  EXPECT_EQ(json("resumed.json").at("rays_taken"), 0) << "they were in the log";
  EXPECT_GT(json("resumed.json").at("rays_resumed"), 26);
  EXPECT_LT(json("resumed.json").at("rays_resumed"), 104);
  expect_fresh("organ.h5", "four.toml");
  for (const char* left : {"organ.h5.grown", "organ.h5.grown.log", "organ.h5.log"})
    EXPECT_FALSE(std::filesystem::exists(folder / left)) << left;
}

TEST_F(Growth, TrainsOnTheDatabaseOfItsSceneOnly) {
  write_file(folder / "two.toml", scene(2));
  write_file(folder / "three.toml", scene(3));
  succeed("precompute two.toml -o two.h5");
  expect_names(be_refused("train three.toml two.h5 -o other").err, {"does not have all rays", "nodes.active"});
  write_file(folder / "deeper.toml", changed(scene(2), "0.008", "0.016"));
  expect_names(be_refused("train deeper.toml two.h5 -o other").err, {"probe.max_displacement_m"});
}

TEST_F(Growth, RunMakesAgainWhatDependsOnAChange) {
  auto text = changed(scene(3), "family = \"rbfn\"", "family = \"modal\"\nmodes = 4");
  text = changed(text, "probes = 8", "probes = 8\ncalibration_rays = 100");
  const std::vector<std::string> files{"database.h5", "train.json", "calibrate.json", "validate.json"};
  const auto times = [&] {
    std::vector<std::filesystem::file_time_type> all;
    for (const auto& file : files) all.push_back(std::filesystem::last_write_time(folder / "out" / file));
    return all;
  };
  const auto run = [&](const std::string& now) {
    write_file(folder / "scene.toml", now);
    return succeed("run scene.toml -o out --resume --json all.json");
  };
  /// Runs again. @return how many of the files are as before
  const auto kept = [&](const std::string& now) {
    const auto before = times();
    run(now);
    const auto after = times();
    const auto first = std::mismatch(before.begin(), before.end(), after.begin()).first - before.begin();
    for (auto i = static_cast<std::size_t>(first); i < files.size(); ++i) EXPECT_NE(before[i], after[i]) << files[i];
    EXPECT_EQ(json("all.json").at("train").at("family"), "modal");
    return first;
  };
  run(text);
  EXPECT_EQ(kept(text), 4);
  text = changed(text, "probes = 8", "probes = 12");
  EXPECT_EQ(kept(text), 3);
  EXPECT_EQ(json("all.json").at("validate").at("probes"), 12);
  text = changed(text, "calibration_rays = 100", "calibration_rays = 120");
  EXPECT_EQ(kept(text), 2);
  succeed("run scene.toml -o anew");
  EXPECT_EQ(read_file(folder / "out/model/model.txt"), read_file(folder / "anew/model/model.txt"));
  text = changed(text, "modes = 4", "modes = 5");
  EXPECT_EQ(kept(text), 1);
  // A model that the run has not made is made again.
  succeed("calibrate out/model out/database.h5 --rays 100 --seed 2");
  EXPECT_EQ(kept(text), 1);
}

TEST_F(Growth, RunUsesWhatItHas) {
  const auto linear = [](int n) {
    const auto text = changed(changed(scene(n), "neo-hookean", "linear"), "family = \"rbfn\"", "family = \"linear\"");
    return changed(text, "check_probes = 0", "check_probes = 1");
  };
  const auto run = [&](int n) {
    write_file(folder / "scene.toml", linear(n));
    return succeed("run scene.toml -o out --resume --json all.json");
  };
  run(1);
  expect_names(be_refused("run scene.toml -o out").err, {"--resume"});
  run(3);
  EXPECT_EQ(json("out/precompute.json").at("rays_taken"), 26);
  expect_fresh("out/database.h5", "scene.toml");
  const auto before = read_file(folder / "out/database.h5");
  write_file(folder / "scene.toml", linear(2));
  expect_names(be_refused("run scene.toml -o out --resume").err, {"other active nodes", "would be lost"});
  EXPECT_EQ(read_file(folder / "out/database.h5"), before);
  write_file(folder / "scene.toml", linear(3));
  succeed("run scene.toml -o out --resume");
  EXPECT_EQ(read_file(folder / "out/database.h5"), before);
}

}  // namespace
}  // namespace phynness::test
