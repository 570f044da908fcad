// Claim: `phynness plan` says before a precompute what it then weighs; from a finished database it takes the
// measured costs to the last digit; what cannot be planned is refused. Times are not compared: the machine
// that tests may be busy.
#include <numeric>
#include <phynness/formats/database.hpp>

#include "command_line.hpp"

namespace phynness::test {
namespace {

using Plans = CommandLine;

TEST_F(Plans, sizes_are_those_of_the_run) {
  write_file(folder / "scene.toml", small_scene());
  const auto planned = phynness("plan scene.toml --ranks 3 --rays 16 --json plan.json");
  ASSERT_EQ(planned.exit_status, 0) << planned.err;
  for (const char* word : {"core-hours", "wall time", "memory", "database", "model", "90 % efficiency"})
    EXPECT_NE(planned.out.find(word), std::string::npos) << word << "\n" << planned.out;
  const auto plan = json("plan.json");
  ASSERT_EQ(phynness("precompute scene.toml -o database.h5 --json run.json").exit_status, 0);
  ASSERT_EQ(phynness("train scene.toml database.h5 -o model").exit_status, 0);
  const auto run = json("run.json");
  EXPECT_EQ(plan["rays"], run["rays"]);
  EXPECT_EQ(plan["rays"].get<int>() * plan["increments"].get<int>(), run["increments"].get<int>());
  EXPECT_EQ(plan["measured"]["rays"], 16);
  EXPECT_EQ(plan["measured"]["nodes"], 2);
  // A prediction to choose a queue by; 16 rays stand for all.
  const auto close = [](double predicted, double actual) { EXPECT_NEAR(predicted, actual, 0.25 * actual); };
  close(plan["database_bytes"], run["database_bytes"]);
  close(plan["model_text_bytes"],
        static_cast<double>(std::filesystem::file_size(folder / "model/model.txt")));
  EXPECT_EQ(plan["mesh_text_bytes"],
            static_cast<double>(std::filesystem::file_size(folder / "model/mesh.txt")));
  EXPECT_GT(plan["memory_bytes_per_rank"].get<double>(), 1e7);
  EXPECT_EQ(plan["curve"].back()["ranks"], 10000);
  EXPECT_GE(plan["ranks_at_90_percent"]["precompute"].get<int>(), 1);

  // From the database: all rays, and their cost as it is stored.
  const auto again = phynness("plan database.h5 --launch-s 0 --fetch-us 0 --open-ms 0 --json measured.json");
  ASSERT_EQ(again.exit_status, 0) << again.err;
  const auto measured = json("measured.json");
  const auto database = Database::open(folder / "database.h5");
  EXPECT_EQ(measured["measured"]["rays"], run["rays"]);
  const double seconds = summarize(database).seconds;
  // Sums in another order.
  EXPECT_NEAR(measured["solving_core_seconds"].get<double>(), seconds, 1e-9 * seconds);
  close(measured["database_bytes"], run["database_bytes"]);
}

TEST_F(Plans, hemispheres_count_what_is_asked_for) {
  auto scene = small_scene();
  const std::string all = "directions = 26";
  scene.replace(scene.find(all), all.size(), "directions = \"hemisphere\"");
  write_file(folder / "scene.toml", scene);
  const auto planned = phynness("plan scene.toml --rays 8 --json plan.json");
  ASSERT_EQ(planned.exit_status, 0) << planned.err;
  // Top of a block, normal z: 9 directions press, 8 are tangential.
  EXPECT_EQ(json("plan.json")["rays_requested"], 2 * 17);
  EXPECT_EQ(json("plan.json")["rays"], 2 * 26);
}

TEST_F(Plans, mirrored_rays_are_stored_but_not_solved) {
  auto scene = small_scene();
  const std::string size = "target_size_m = 0.025";
  scene.replace(scene.find(size), size.size(), size + "\nsymmetry = \"x\"");
  const auto from = scene.find("active ="), to = scene.find("[probe]");
  scene.replace(from, to - from,
                "active = [{ nearest = { point_fraction = [0, 0, 1] } }, { nearest = { point_fraction = [1, "
                "0, 1] } }]\n");
  write_file(folder / "scene.toml", scene);
  ASSERT_EQ(phynness("precompute scene.toml -o database.h5 --json run.json").exit_status, 0);
  const auto run = json("run.json");
  EXPECT_EQ(run["rays"], 26);
  for (const char* source : {"scene.toml", "database.h5"}) {
    const auto planned = phynness(std::string("plan ") + source + " --rays 16 --json plan.json");
    ASSERT_EQ(planned.exit_status, 0) << planned.err;
    const auto plan = json("plan.json");
    EXPECT_EQ(plan["rays"], 26) << source;
    EXPECT_EQ(plan["rays_requested"], 26) << source;
    EXPECT_EQ(plan["rays_mirrored"], 26) << source;
    EXPECT_EQ(plan["measured"]["nodes"], 1) << source;
    EXPECT_NE(planned.out.find("26 rays more"), std::string::npos) << planned.out;
    // A file of half the rays would be a third too small.
    EXPECT_NEAR(plan["database_bytes"].get<double>(), run["database_bytes"].get<double>(),
                0.25 * run["database_bytes"].get<double>())
        << source;
  }
}

TEST_F(Plans, what_cannot_be_planned_is_refused) {
  write_file(folder / "scene.toml", small_scene());
  const auto refused = [&](const std::string& line, const char* word) {
    const auto done = shell(line);
    EXPECT_EQ(done.exit_status, 2) << line << "\n" << done.err;
    EXPECT_NE(done.err.find(word), std::string::npos) << line << "\n" << done.err;
  };
  refused("\"$PHYNNESS\" plan missing.toml", "missing.toml");
  refused("\"$PHYNNESS\" plan missing.h5", "missing.h5");
  refused("\"$PHYNNESS\" plan scene.toml --json scene.toml", "overwrite");
  refused("\"$PHYNNESS\" plan scene.toml --ranks 0", "--ranks");
  refused("mpirun -n 2 --oversubscribe \"$PHYNNESS\" plan scene.toml", "made by one process");
  // Interrupted: says so, leaves nothing.
  const auto stopped = shell(
      "\"$PHYNNESS\" plan scene.toml --rays 100000 --json plan.json & pid=$!; sleep 1; kill -TERM $pid; wait "
      "$pid");
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.json.part"));
  if (stopped.exit_status != 0) {
    EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
    EXPECT_NE(stopped.err.find("interrupted"), std::string::npos) << stopped.err;
  }
}

}  // namespace
}  // namespace phynness::test
