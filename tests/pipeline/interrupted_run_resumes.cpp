// Claim: a killed or interrupted run keeps its finished rays, and --resume leads to the database of an uninterrupted
// run. The process is killed after a fixed number of logged rays, which the size of the log shows.
#include <phynness/formats/database.hpp>
#include <phynness/formats/database_lock.hpp>

#include "command_line.hpp"
#include "same_results.hpp"

namespace phynness::test {
namespace {

using Interrupted = CommandLine;

TEST_F(Interrupted, KilledRunResumesToTheSameDatabase) {
  write_file(folder / "scene.toml", small_scene("P1", 6));
  make_once({"precompute scene.toml -o whole.h5"});
  killed("precompute scene.toml -o database.h5", "database.h5.log/*");
  EXPECT_FALSE(Database::is_complete(folder / "database.h5"));
  expect_names(succeed("info database.h5").out, {"unfinished"});
  // Not finished: training refuses and names the remedy.
  expect_names(be_refused("train scene.toml database.h5 -o model").err, {"--resume"});
  // Starting over by accident is refused as well.
  be_refused("precompute scene.toml -o database.h5");

  // No folder for temporary files is needed: Open MPI's would be shared by all processes that work alone, and removed
  // by the first that ends.
  const auto resumed =
      shell("TMPDIR=scene.toml \"$PHYNNESS\" precompute scene.toml -o database.h5 --resume --json resumed.json");
  EXPECT_EQ(resumed.exit_status, 0) << resumed.err;
  EXPECT_GT(json("resumed.json").at("rays_resumed").get<int>(), 0);
  EXPECT_LT(json("resumed.json").at("rays_resumed").get<int>(), 52);
  expect_same_results(folder / "database.h5", folder / "whole.h5");
}

TEST_F(Interrupted, SigtermOfRunEndsItsStages) {
  write_file(folder / "scene.toml", small_scene("P1", 6));
  const auto stopped = killed("run scene.toml -o stopped_run", "stopped_run/database.h5.log/*", "TERM");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  EXPECT_EQ(shell("pgrep -f \"[p]hynness precompute scene.toml -o stopped_run\"").out, "") << "a stage outlived run";
  EXPECT_FALSE(Database::is_complete(folder / "stopped_run/database.h5"));
}

TEST_F(Interrupted, FinishedRunKeepsItsRelaxationAndSaysSo) {
  const auto with_terms = [](const std::string& g) {
    return changed(small_scene(), "law = ", "relaxation = { g = [" + g + "], tau_s = [0.5] }\nlaw = ");
  };
  const std::string note = "database.h5 keeps the relaxation of the scene with which it was begun";
  write_file(folder / "scene.toml", with_terms("0.25"));
  const std::string is_new = "database.h5 does not exist yet";
  expect_names(unbroken(succeed("precompute scene.toml -o database.h5 --resume").err), {is_new});
  const auto again = unbroken(succeed("precompute scene.toml -o database.h5 --resume").err);
  for (const auto& absent : {note, is_new}) EXPECT_EQ(again.find(absent), std::string::npos);
  write_file(folder / "scene.toml", with_terms("0.75"));
  expect_names(unbroken(succeed("precompute scene.toml -o database.h5 --resume").err), {note});
  succeed("info database.h5 --json info.json");
  EXPECT_EQ(json("info.json").at("relaxation").at(0).at("g"), 0.25);
}

/// Of the comparison with a finer solution nothing else depends: a check that fails costs the distance alone, and a run
/// that is interrupted in it keeps the database.
TEST_F(Interrupted, CheckThatFailsCostsTheDistanceAlone) {
  write_file(folder / "scene.toml", changed(small_scene(), "check_probes = 0", "check_probes = 2"));
  succeed("run scene.toml -o whole");
  /// As soon as the check of a run is at work.
  const auto in_check = [&](const std::string& out, const std::string& kill) {
    return signalled("\"$PHYNNESS\" run scene.toml -o " + out, "check=$(pgrep -f \"[-]-json " + out + "/check.json\")",
                     kill);
  };
  const auto failed = in_check("failed", "kill -KILL $check");
  EXPECT_EQ(failed.exit_status, 0) << failed.err;
  expect_names(failed.err, {"check was ended by signal 9", "warning: the finite elements are not compared"});
  expect_names(unbroken(failed.out), {"compared with finer ones: not measured (no check, or it failed)"});
  EXPECT_FALSE(std::filesystem::exists(folder / "failed/check.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "failed/validate.json"));
  EXPECT_NE(read_file(folder / "whole/model/model.txt").find("\nfiner "), std::string::npos);
  EXPECT_EQ(read_file(folder / "failed/model/model.txt").find("\nfiner "), std::string::npos);

  const auto stopped = in_check("stopped", "kill -INT $pid");
  EXPECT_EQ(stopped.exit_status, 1) << stopped.err;
  expect_names(stopped.err, {"interrupted in stage check", "earlier stages are kept", "--resume"});
  EXPECT_EQ(shell("pgrep -f \"[-]-json stopped/check.json\"").out, "") << "the check outlived run";
  EXPECT_FALSE(std::filesystem::exists(folder / "stopped/model"));
  const auto kept = read_file(folder / "stopped/database.h5");
  EXPECT_TRUE(Database::is_complete(folder / "stopped/database.h5"));

  for (const char* out : {"failed", "stopped"}) {
    const auto resumed = succeed(std::string("run scene.toml --resume -o ") + out);
    expect_names(resumed.err, {"52 of 52 rays are already solved"});
    EXPECT_EQ(read_file(folder / out / "model/model.txt"), read_file(folder / "whole/model/model.txt")) << out;
  }
  EXPECT_EQ(read_file(folder / "stopped/database.h5"), kept);

  {
    const DatabaseLock lock(folder / "stopped/database.h5");
    for (const char* resume : {"", " --resume"})
      expect_names(be_refused(std::string("run scene.toml -o stopped") + resume).err,
                   {"is in use", "process " + std::to_string(getpid())});
  }

  // A scene with check_probes does not limit the time, so that a check which lacked time is made again.
  auto check = json("whole/check.json");
  const double seconds = check.at("seconds");
  check["sufficient_seconds"] = 3 * seconds + 1000;
  write_file(folder / "whole/check.json", check.dump());
  succeed("run scene.toml --resume -o whole");
  EXPECT_LT(json("whole/check.json").at("sufficient_seconds"), 1000);

  EXPECT_EQ(json("whole/check.json").at("most_probes"), 2);
  write_file(folder / "scene.toml", changed(small_scene(), "check_probes = 0", "check_probes = 3"));
  succeed("run scene.toml --resume -o whole");
  EXPECT_EQ(json("whole/check.json").at("most_probes"), 3);
}

}  // namespace
}  // namespace phynness::test
