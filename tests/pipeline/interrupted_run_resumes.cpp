// Claim: a killed or interrupted run keeps its finished rays, and --resume leads to the database of an uninterrupted
// run. The process is killed after a fixed number of logged rays, which the size of the log shows.
#include <phynness/formats/database.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

using Interrupted = CommandLine;

TEST_F(Interrupted, KilledRunResumesToTheSameDatabase) {
  write_file(folder / "scene.toml", small_scene("P1", 6));
  succeed("precompute scene.toml -o whole.h5");
  const auto killed = shell(
      "\"$PHYNNESS\" precompute scene.toml -o database.h5 & pid=$!; "
      "for i in $(seq 2000); do "
      "  size=$(cat database.h5.log/* 2>/dev/null | wc -c); [ \"$size\" -gt 40000 ] && break; "
      "  sleep 0.01; done; kill -KILL $pid; wait $pid");
  ASSERT_NE(killed.exit_status, 0) << "it finished before the signal came: the scene is too small for this test";
  EXPECT_FALSE(Database::is_complete(folder / "database.h5"));
  const auto info = succeed("info database.h5");
  EXPECT_NE(info.out.find("unfinished"), std::string::npos) << info.out;
  // Not finished: training refuses and names the remedy.
  const auto train = be_refused("train scene.toml database.h5 -o model");
  EXPECT_NE(train.err.find("--resume"), std::string::npos) << train.err;
  // Starting over by accident is refused as well.
  be_refused("precompute scene.toml -o database.h5");

  const auto resumed = succeed("precompute scene.toml -o database.h5 --resume --json resumed.json");
  EXPECT_GT(json("resumed.json").at("rays_resumed").get<int>(), 0);
  EXPECT_LT(json("resumed.json").at("rays_resumed").get<int>(), 52);
  expect_same_results(folder / "database.h5", folder / "whole.h5");
}

TEST_F(Interrupted, SigtermOfRunEndsItsStages) {
  write_file(folder / "scene.toml", small_scene("P1", 6));
  const auto stopped = shell(
      "\"$PHYNNESS\" run scene.toml -o stopped_run & pid=$!; "
      "for i in $(seq 2000); do "
      "  size=$(cat stopped_run/database.h5.log/* 2>/dev/null | wc -c); [ \"$size\" -gt 40000 ] && break; "
      "  sleep 0.01; done; kill -TERM $pid; wait $pid; status=$?; "
      "pgrep -f \"[p]hynness precompute scene.toml -o stopped_run\" > left.txt || true; exit $status");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  EXPECT_EQ(read_file(folder / "left.txt"), "") << "a stage outlived run";
  EXPECT_FALSE(Database::is_complete(folder / "stopped_run/database.h5"));
}

TEST_F(Interrupted, FinishedRunKeepsItsRelaxationAndSaysSo) {
  const auto with_terms = [](const std::string& g) {
    return changed(small_scene(), "law = ", "relaxation = { g = [" + g + "], tau_s = [0.5] }\nlaw = ");
  };
  const std::string note = "database.h5 keeps the relaxation of the scene with which it was begun";
  write_file(folder / "scene.toml", with_terms("0.25"));
  succeed("precompute scene.toml -o database.h5");
  EXPECT_EQ(unbroken(succeed("precompute scene.toml -o database.h5 --resume").err).find(note), std::string::npos);
  write_file(folder / "scene.toml", with_terms("0.75"));
  expect_names(unbroken(succeed("precompute scene.toml -o database.h5 --resume").err), {note});
  succeed("info database.h5 --json info.json");
  EXPECT_EQ(json("info.json").at("relaxation").at(0).at("g"), 0.25);
}

/// Runs the pipeline and sends `signal` to the run, or to its check alone, as soon as the check is at work.
std::string run_and_signal_check(const std::string& out, const std::string& signal, bool to_run) {
  return "\"$PHYNNESS\" run scene.toml -o " + out + " & run=$!; for i in $(seq 6000); do check=$(pgrep -f \"[-]-json " +
         out + "/check.json\") && break; sleep 0.01; done; kill -" + signal + " " + (to_run ? "$run" : "$check") +
         "; wait $run; status=$?; pgrep -f \"[-]-json " + out + "/check.json\" > left.txt; exit $status";
}

/// Of the comparison with a finer solution nothing else depends: a check that fails costs the distance alone, and a run
/// that is interrupted in it keeps the database.
TEST_F(Interrupted, CheckThatFailsCostsTheDistanceAlone) {
  write_file(folder / "scene.toml", changed(small_scene(), "check_probes = 0", "check_probes = 2"));
  succeed("run scene.toml -o whole");
  const auto failed = shell(run_and_signal_check("failed", "KILL", false));
  EXPECT_EQ(failed.exit_status, 0) << failed.err;
  expect_names(failed.err, {"check was ended by signal 9", "warning: the finite elements are not compared"});
  expect_names(unbroken(failed.out), {"compared with finer ones: not measured (no check, or it failed)"});
  EXPECT_FALSE(std::filesystem::exists(folder / "failed/check.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "failed/validate.json"));
  EXPECT_NE(read_file(folder / "whole/model/model.txt").find("\nfiner "), std::string::npos);
  EXPECT_EQ(read_file(folder / "failed/model/model.txt").find("\nfiner "), std::string::npos);

  const auto stopped = shell(run_and_signal_check("stopped", "INT", true));
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  expect_names(stopped.err, {"interrupted in stage check", "solved rays are kept", "--resume"});
  EXPECT_EQ(read_file(folder / "left.txt"), "") << "the check outlived run";
  EXPECT_FALSE(std::filesystem::exists(folder / "stopped/model"));
  const auto kept = read_file(folder / "stopped/database.h5");
  EXPECT_TRUE(Database::is_complete(folder / "stopped/database.h5"));

  for (const char* out : {"failed", "stopped"}) {
    const auto resumed = succeed(std::string("run scene.toml --resume -o ") + out);
    expect_names(resumed.err, {"52 of 52 rays are already solved"});
    EXPECT_EQ(read_file(folder / out / "model/model.txt"), read_file(folder / "whole/model/model.txt")) << out;
  }
  EXPECT_EQ(read_file(folder / "stopped/database.h5"), kept);
}

}  // namespace
}  // namespace phynness::test
