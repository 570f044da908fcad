// Claim: `phynness plan` predicts the sizes of the files of a precompute run. For a finished database it uses exactly
// the measured costs. The tasks that it simulates are those of precompute in the same order. Input that cannot be
// planned is refused. Times are not compared, because the machine may have other load.
#include <numeric>
#include <phynness/formats/database.hpp>
#include <phynness/planning/schedule.hpp>

#include "../../formats/src/database_scan.hpp"
#include "command_line.hpp"

namespace phynness::test {
namespace {

using Plans = CommandLine;

TEST_F(Plans, sizes_are_those_of_the_run) {
  write_file(folder / "scene.toml", small_scene());
  const auto planned = phynness("plan scene.toml --ranks 3 --rays 16 --json plan.json");
  ASSERT_EQ(planned.exit_status, 0) << planned.err;
  for (const char* word :
       {"precompute takes about", "on 3 ranks", "CPU time", "memory", "database", "model", "ranks of use", "limit"})
    EXPECT_NE(planned.out.find(word), std::string::npos) << word << "\n" << planned.out;
  const auto plan = json("plan.json");
  ASSERT_EQ(phynness("precompute scene.toml -o database.h5 --json run.json").exit_status, 0);
  ASSERT_EQ(phynness("train scene.toml database.h5 -o model").exit_status, 0);
  const auto run = json("run.json");
  EXPECT_EQ(plan["rays"], run["rays"]);
  EXPECT_EQ(plan["rays"].get<int>() * plan["increments"].get<int>(), run["increments"].get<int>());
  EXPECT_EQ(plan["measured"]["rays"], 16);
  EXPECT_EQ(plan["measured"]["nodes"], 2);
  // Two nodes are two independent draws: no standard error.
  EXPECT_NE(planned.out.find("guess from 16 rays of 52 at 2 nodes"), std::string::npos) << planned.out;
  EXPECT_EQ(planned.out.find('%'), std::string::npos) << planned.out;
  EXPECT_TRUE(plan["measured"]["is_guess"].get<bool>());
  EXPECT_TRUE(plan["measured"]["relative_standard_error"].is_null());
  // A prediction to choose a queue by; 16 rays stand for all.
  const auto close = [](double predicted, double actual) { EXPECT_NEAR(predicted, actual, 0.25 * actual); };
  close(plan["database_bytes"], run["database_bytes"]);
  close(plan["model_text_bytes"], static_cast<double>(std::filesystem::file_size(folder / "model/model.txt")));
  EXPECT_EQ(plan["mesh_text_bytes"], static_cast<double>(std::filesystem::file_size(folder / "model/mesh.txt")));
  EXPECT_GT(plan["memory_bytes_per_rank"].get<double>(), 1e7);
  EXPECT_EQ(plan["curve"].back()["ranks"], 10000);
  EXPECT_GE(plan["ranks_of_use"].get<int>(), plan["ranks_at_90_percent"].get<int>());
  EXPECT_GE(plan["ranks_at_90_percent"].get<int>(), 1);

  // From the database: all rays, and their cost as it is stored.
  const auto again = phynness("plan database.h5 --launch-s 0 --fetch-us 0 --open-ms 0 --json measured.json");
  ASSERT_EQ(again.exit_status, 0) << again.err;
  const auto measured = json("measured.json");
  const auto database = Database::open(folder / "database.h5");
  EXPECT_EQ(measured["measured"]["rays"], run["rays"]);
  EXPECT_FALSE(measured["measured"]["is_guess"].get<bool>());
  const double seconds = summarize(database).seconds;
  // Sums in another order.
  EXPECT_NEAR(measured["solving_core_seconds"].get<double>(), seconds, 1e-9 * seconds);
  close(measured["database_bytes"], run["database_bytes"]);
}

TEST_F(Plans, the_table_is_printed_on_request_with_the_numbers_for_machines) {
  write_file(folder / "scene.toml", small_scene());
  const auto planned = phynness("plan scene.toml --rays 2 --ranks 3 --table --json plan.json");
  ASSERT_EQ(planned.exit_status, 0) << planned.err;
  EXPECT_NE(planned.out.find("efficiency"), std::string::npos) << planned.out;
  const auto plan = json("plan.json");
  std::vector<int> ranks;
  for (const auto& at : plan["curve"]) {
    char line[80];
    ranks.push_back(at["ranks"]);
    std::snprintf(line, sizeof line, "%9.1f %%", 100 * at["efficiency"].get<double>());
    EXPECT_NE(planned.out.find(line), std::string::npos) << line << "\n" << planned.out;
    if (ranks.back() == 3) {
      EXPECT_EQ(at["wall_seconds"], plan["wall_seconds"]);
    }
  }
  EXPECT_EQ(ranks, (std::vector<int>{1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000}));
  // Without a request there is no table, and the ranks are those of this machine.
  const auto answer = phynness("plan scene.toml --rays 2");
  EXPECT_EQ(answer.out.find("efficiency"), std::string::npos) << answer.out;
  EXPECT_NE(answer.out.find("processor cores of this machine"), std::string::npos) << answer.out;
}

/// The tasks of `plan` in a log: each whole, one after the other, in the order in which they are handed out.
/// @return how many
int tasks_in(const std::vector<RayIndex>& log, const Schedule& plan, const RayWork& work, std::vector<int>& taken) {
  int n_tasks = 0;
  std::size_t at = 0, task = 0;
  while (at < log.size()) {
    const auto starts_here = [&](const TakenTask& t) {
      const auto& first = work.rays[static_cast<std::size_t>(t.first)];
      return first.active == log[at].active && first.direction == log[at].direction;
    };
    while (task < plan.tasks.size() && !starts_here(plan.tasks[task])) ++task;
    if (task == plan.tasks.size()) {
      ADD_FAILURE() << "no task of the plan begins with record " << at << " of the log, or too early";
      return n_tasks;
    }
    for (auto i = plan.tasks[task].first; i < plan.tasks[task].end; ++i, ++at) {
      const auto& ray = work.rays[static_cast<std::size_t>(i)];
      if (at == log.size() || log[at].active != ray.active || log[at].direction != ray.direction) {
        ADD_FAILURE() << "task " << task << " of the plan is not whole in the log";
        return n_tasks;
      }
    }
    ++taken[task];
    ++n_tasks;
  }
  return n_tasks;
}

// Which rank takes which task depends on how fast each one is, which no test can repeat; which rays make a
// task, and the order of the tasks, do not. On one rank this is the whole schedule. A shard of all rays keeps
// its logs.
TEST_F(Plans, tasks_are_those_of_precompute) {
  write_file(folder / "scene.toml", small_scene());
  ASSERT_EQ(phynness("precompute scene.toml -o whole.h5").exit_status, 0);
  const auto header = Database::open(folder / "whole.h5").header();
  RayWork work;
  work.rays = rays_left(header, std::vector<char>(header.sets.active.size() * header.directions.size(), 0));
  work.seconds.assign(work.rays.size(), 1);
  for (const int ranks : {1, 3}) {
    const std::string n = std::to_string(ranks);
    const auto done = shell("mpirun --oversubscribe -n " + n + " \"$PHYNNESS\" precompute scene.toml -o run" + n +
                            ".h5 --shard 0/1 --json run.json");
    ASSERT_EQ(done.exit_status, 0) << done.err;
    ASSERT_EQ(phynness("plan whole.h5 --ranks " + n + " --json plan.json").exit_status, 0);
    const auto run = json("run.json");
    const auto schedule = simulate(work, {}, ranks);
    EXPECT_EQ(json("plan.json")["tasks"], schedule.tasks.size());
    const auto index = database_log::scan(folder / ("run" + n + ".shard-0-of-1.h5"), header);
    ASSERT_EQ(index.entries.size(), work.rays.size());
    std::vector<std::vector<RayIndex>> logs(index.logs.size());
    for (const auto& entry : index.entries)
      logs[static_cast<std::size_t>(entry.log)].push_back({entry.active, entry.direction});
    std::vector<int> taken(schedule.tasks.size(), 0);
    std::vector<std::int64_t> counted, reported;
    for (const auto& log : logs)
      if (!log.empty()) counted.push_back(tasks_in(log, schedule, work, taken));
    for (const auto& rank : run["per_rank"])
      if (rank["tasks"] > 0) reported.push_back(rank["tasks"]);
    EXPECT_EQ(counted, reported) << ranks;
    EXPECT_EQ(taken, std::vector<int>(schedule.tasks.size(), 1)) << ranks;
    if (ranks == 1) {
      EXPECT_EQ(schedule.tasks.size(), 2u);  // all rays of a node
    } else {
      EXPECT_GT(schedule.tasks.size(), 6u);
    }
  }
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
    expect_names(planned.out, {"mirrored      26"});
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
    SCOPED_TRACE(line);
    expect_names(done.err, {word});
  };
  refused("\"$PHYNNESS\" plan missing.toml", "missing.toml");
  refused("\"$PHYNNESS\" plan missing.h5", "missing.h5");
  refused("\"$PHYNNESS\" plan scene.toml --json scene.toml", "overwrite");
  refused("\"$PHYNNESS\" plan scene.toml --ranks 0", "--ranks");
  refused("mpirun -n 2 --oversubscribe \"$PHYNNESS\" plan scene.toml", "2 ranks");
}

TEST_F(Plans, an_interrupted_plan_says_so_and_leaves_nothing) {
  // 52 rays of 400 increments take some ten seconds; the signal comes after the first of them.
  write_file(folder / "scene.toml", small_scene("P2", 400));
  const auto stopped = shell(
      "PHYNNESS_PROGRESS=1 \"$PHYNNESS\" plan scene.toml --rays 100000 --json plan.json 2>progress.txt & "
      "pid=$!; "
      "for i in $(seq 3000); do grep -qE ' [1-9][0-9]*/[0-9]+ rays' progress.txt && break; sleep 0.01; done; "
      "kill -TERM $pid; wait $pid; status=$?; cat progress.txt >&2; exit $status");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  EXPECT_NE(stopped.err.find("interrupted"), std::string::npos) << stopped.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "plan.json.part"));
}

}  // namespace
}  // namespace phynness::test
