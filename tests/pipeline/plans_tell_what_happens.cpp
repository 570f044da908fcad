// Claim: `phynness plan` predicts the sizes of the files of a precompute run, and those of calibrate and validate, in
// eight lines. Input that cannot be planned is refused. Times are not compared, because the machine may have other
// load.
#include <algorithm>

#include "command_line.hpp"

namespace phynness::test {
namespace {

using Plans = CommandLine;

TEST_F(Plans, sizes_are_those_of_the_run) {
  write_file(folder / "scene.toml", small_scene());
  const auto planned = succeed("plan scene.toml --ranks 3 --rays 16 --json plan.json");
  EXPECT_EQ(std::count(planned.out.begin(), planned.out.end(), '\n'), 8) << planned.out;
  expect_names(planned.out, {"on 3 ranks; all times here are of idle cores", "memory", "database", "useful"});
  const auto plan = json("plan.json");
  succeed("precompute scene.toml -o database.h5 --json run.json");
  const auto run = json("run.json");
  EXPECT_EQ(plan["rays"], run["rays"]);
  EXPECT_EQ(plan["rays"].get<int>() * plan["increments"].get<int>(), run["increments"].get<int>());
  EXPECT_EQ(plan["measured"]["rays"], 16);
  EXPECT_EQ(plan["measured"]["nodes"], 2);
  // Two nodes are two independent draws: no standard error.
  EXPECT_NE(planned.out.find(" to solve, "), std::string::npos) << planned.out;
  EXPECT_EQ(planned.out.find('%'), std::string::npos) << planned.out;
  EXPECT_TRUE(plan["measured"]["relative_standard_error"].is_null());
  // A prediction to choose a queue by: compression and the file's own structure are not computed.
  const auto close = [](double predicted, double actual) { EXPECT_NEAR(predicted, actual, 0.25 * actual); };
  close(plan["database_bytes"], run["database_bytes"]);
  EXPECT_GT(plan["memory_bytes_per_rank"].get<double>(), 1e7);
  EXPECT_GE(plan["ranks_of_use"].get<int>(), 1);
  EXPECT_EQ(plan["check_seconds"], 0);
  EXPECT_EQ(plan["check_memory_bytes"], 0);
  EXPECT_EQ(plan["probes"], 8);
  EXPECT_EQ(plan["calibration_rays"], 100);
  // Without a request the ranks are those of this machine, run compares with a finer solution, and calibrate and
  // validate have the planned sizes. Those of a small database are the least ones.
  auto checked = small_scene();
  write_file(folder / "scene.toml", checked.erase(checked.find("probes = 8")));
  const auto all = succeed("plan scene.toml --rays 2 --json plan.json");
  expect_names(unbroken(all.out),
               {"processor cores of this machine", "check     at most 1 min 00 s more in phynness run",
                "calibrate 100 rays and validate 50 probes in phynness run", " for check; this machine has "});
  // The sum has the check, whose limit is a minute.
  EXPECT_TRUE(
      std::regex_search(all.out, std::regex("\nall       about [0-9]+ min [0-9]+ s in phynness run, without train\n")))
      << all.out;
  EXPECT_GT(json("plan.json").at("calibrate_seconds"), 0.0);
  EXPECT_GT(json("plan.json").at("validate_seconds"), 0.0);
  std::filesystem::remove_all(folder / "model");
  std::filesystem::remove(folder / "database.h5");
  succeed("precompute scene.toml -o database.h5");
  succeed("train scene.toml database.h5 -o model --family modal");
  succeed("calibrate model database.h5 --json calibrate.json");
  EXPECT_EQ(json("calibrate.json").at("rays"), 100);
  succeed("validate scene.toml model --json validate.json");
  EXPECT_EQ(json("validate.json").at("probes"), 50);
}

TEST_F(Plans, tell_the_times_of_a_body) {
  const auto several = [](int tools) {
    return changed(changed(small_scene("p1-p1"), "[nodes]\n", "[nodes]\noutput = \"free\"\n"), "[probe]\n",
                   "[probe]\nkind = \"patch\"\ntool_radius_m = 0.06\ntools = " + std::to_string(tools) + "\n");
  };
  write_file(folder / "scene.toml", several(2));
  expect_names(unbroken(succeed("plan scene.toml --rays 2").out), {"body      of several tools: reduce about "});
  write_file(folder / "scene.toml", several(1));
  EXPECT_EQ(succeed("plan scene.toml --rays 2").out.find("reduce"), std::string::npos);
}

TEST_F(Plans, hemispheres_count_what_is_asked_for) {
  write_file(folder / "scene.toml", changed(small_scene(), "directions = 26", "directions = \"hemisphere\""));
  succeed("plan scene.toml --rays 8 --json plan.json");
  // Top of a block, normal z: 9 directions press, 8 are tangential.
  EXPECT_EQ(json("plan.json")["rays_requested"], 2 * 17);
  EXPECT_EQ(json("plan.json")["rays"], 2 * 26);
}

TEST_F(Plans, what_cannot_be_planned_is_refused) {
  write_file(folder / "scene.toml", small_scene());
  const auto refused = [&](const std::string& line, const char* word) {
    const auto done = shell(line);
    EXPECT_EQ(done.exit_status, 2) << line << "\n" << done.err;
    SCOPED_TRACE(line);
    expect_names(done.err, {word});
  };
  refused("\"$PHYNNESS\" plan missing.toml", "missing.toml");
  refused("\"$PHYNNESS\" plan scene.toml --json scene.toml", "overwrite");
  refused("\"$PHYNNESS\" plan scene.toml --ranks 0", "--ranks");
  refused("mpirun -n 2 --oversubscribe \"$PHYNNESS\" plan scene.toml", "2 ranks");
}

TEST_F(Plans, an_interrupted_plan_says_so_and_leaves_nothing) {
  // 52 rays of 400 increments take some ten seconds; the signal comes after the first of them.
  write_file(folder / "scene.toml", small_scene("P2", 400));
  const auto stopped =
      interrupted("plan scene.toml --rays 100000 --json plan.json", " [1-9][0-9]*/[0-9]+ rays", "TERM");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  EXPECT_NE(stopped.err.find("interrupted"), std::string::npos) << stopped.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.json.part"));
}

}  // namespace
}  // namespace phynness::test
