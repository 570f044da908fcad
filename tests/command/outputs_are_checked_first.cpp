// Claims: a command whose output cannot be written says so before it works, and leaves all other files as they were. An
// output that fails all the same costs no other output. --json - writes JSON alone to stdout, whatever the command.
#include <algorithm>

#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

/// Every command with --json. The word @ is replaced by outputs, NODE by an active node.
const char* const lines[] = {"mesh scene.toml -o fresh/m.msh @",
                             "plan scene.toml --rays 2 @",
                             "check scene.toml --probes 1 @",
                             "precompute scene.toml -o fresh/d.h5 @",
                             "train scene.toml d.h5 -o fresh/model @",
                             "validate scene.toml model --probes 2 @",
                             "tune scene.toml d.h5 -o fresh/tuned --probes 2 @",
                             "eval model --node NODE --displacement 0,0,-0.001 @",
                             "bench model @",
                             "solve scene.toml --node NODE --displacement 0,0,-0.001 @",
                             "export model -o fresh/c @",
                             "info d.h5 @",
                             "run scene.toml -o fresh/out @"};

class Outputs : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
    fs::create_directory(folder / "fresh");
    for (const char* line :
         {"precompute scene.toml -o d.h5", "train scene.toml d.h5 -o model", "info d.h5 --json info.json"}) {
      succeed(line);
    }
    node = std::to_string(json("info.json").at("active").at(0).get<int>());
  }
  std::string with(std::string line, const std::string& outputs) const {
    line.replace(line.find('@'), 1, outputs);
    if (const auto at = line.find("NODE"); at != std::string::npos) line.replace(at, 4, node);
    return line;
  }
  std::string eval() const { return "eval model --node " + node + " --displacement 0,0,-0.001 "; }
  std::string node;
};

TEST_F(Outputs, PlacesThatCannotBeAreRefusedBeforeTheWork) {
  fs::create_directory(folder / "a_folder");
  write_file(folder / "a_file", "text");
  for (const char* line : lines)
    for (const char* place : {"nowhere/x.json", "a_folder", "a_file/x.json"}) {
      const auto outcome = be_refused(with(line, std::string("--json ") + place));
      expect_error(outcome.err, {"an output cannot be written", "--json", place});
      EXPECT_EQ(outcome.out, "") << line;
      ASSERT_TRUE(fs::is_empty(folder / "fresh")) << line;
    }
  for (const char* line : {"train scene.toml d.h5 -o a_file", "tune scene.toml d.h5 -o a_file/m",
                           "export model -o a_file/c", "mesh scene.toml -o a_folder", "run scene.toml -o a_file",
                           "validate scene.toml model --report nowhere/r.html"}) {
    const auto outcome = be_refused(line);
    EXPECT_NE(outcome.err.find("remedy: "), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "") << line;
  }
  EXPECT_EQ(read_file(folder / "a_file"), "text");
  // Folders that the command makes itself.
  succeed("train scene.toml d.h5 -o fresh/new/model --json fresh/new/model/train.json");
}

TEST_F(Outputs, OfAReadOnlyFolderAreRefused) {
  fs::create_directory(folder / "closed");
  ASSERT_EQ(shell("chmod 555 closed && chmod 777 fresh .").exit_status, 0);
  const auto as_user = [&](const std::string& line) {
    return shell((geteuid() == 0 ? "setpriv --reuid=65534 --clear-groups \"$PHYNNESS\" " : "\"$PHYNNESS\" ") + line);
  };
  if (as_user("--version").exit_status != 0) GTEST_SKIP() << "nobody may run the command";
  const auto outcome = as_user(eval() + "--json closed/x.json --deformation fresh/ok.csv --surface fresh/ok.vtu");
  EXPECT_EQ(outcome.exit_status, 2);
  expect_error(outcome.err, {"--json", "closed/x.json", "not writable"});
  EXPECT_TRUE(fs::is_empty(folder / "fresh"));
}

TEST_F(Outputs, ThatFailAtTheEndCostNoOthers) {
  // /dev/full takes no byte, which shows only when something is written.
  fs::create_symlink("/dev/full", folder / "full.vtu");
  const auto written = phynness(eval() + "--deformation /dev/full --json fresh/ok.json --surface full.vtu");
  EXPECT_EQ(written.exit_status, 1);
  EXPECT_TRUE(json("fresh/ok.json").contains("tools"));
  for (const char* part : {"/dev/full", "full.vtu"})
    EXPECT_NE(written.err.find(std::string("writing failed: ") + part), std::string::npos) << written.err;
  EXPECT_EQ(phynness("mesh scene.toml -o fresh/m.msh --json /dev/full").exit_status, 1);
  EXPECT_TRUE(fs::exists(folder / "fresh/m.msh"));
  EXPECT_EQ(phynness("mesh scene.toml -o /dev/full --json fresh/m.json").exit_status, 1);
  EXPECT_TRUE(json("fresh/m.json").contains("nodes"));
  EXPECT_EQ(phynness("export model -o fresh/c --json /dev/full").exit_status, 1);
  EXPECT_TRUE(fs::exists(folder / "fresh/c/model.bin"));
  EXPECT_EQ(phynness("validate scene.toml model --probes 2 --json /dev/full --report fresh/r.html").exit_status, 1);
  EXPECT_TRUE(fs::exists(folder / "fresh/r.html"));
}

TEST_F(Outputs, OfTheFormatJsonGoToStdout) {
  for (const char* line : lines) {
    const auto outcome = succeed(with(line, "--json -"));
    EXPECT_TRUE(nlohmann::json::parse(outcome.out, nullptr, false).is_object()) << line << "\n" << outcome.out;
  }
  EXPECT_FALSE(fs::exists(folder / "-"));
  const auto other = be_refused("mesh scene.toml -o -");
  expect_error(other.err, {"--output -", "./-"});
  // A disk that is full.
  EXPECT_EQ(shell("\"$PHYNNESS\" info d.h5 --json - >/dev/full").exit_status, 1);
}

TEST_F(Outputs, OfARunOfAnotherSceneAreLeftAsTheyWere) {
  succeed("run scene.toml -o fresh");
  const auto bytes = [&] {
    std::string all;
    std::vector<fs::path> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "fresh"))
      if (entry.is_regular_file()) names.push_back(entry.path());
    std::sort(names.begin(), names.end());
    for (const auto& name : names) all += name.string() + "\n" + read_file(name);
    return all;
  };
  const auto before = bytes();
  auto text = small_scene();
  text.replace(text.find("0.05]"), 5, "0.06]");
  write_file(folder / "other.toml", text);
  for (const char* line : {"run other.toml -o fresh", "run other.toml -o fresh --resume", "run scene.toml -o fresh"}) {
    const auto outcome = be_refused(line);
    EXPECT_NE(outcome.err.find("fresh/database.h5"), std::string::npos) << outcome.err;
    ASSERT_TRUE(bytes() == before) << line;
  }
}

TEST_F(Outputs, OfAMeshThatIsRefusedAreLeftAsTheyWere) {
  succeed("mesh scene.toml -o fresh/m.msh");
  const auto before = read_file(folder / "fresh/m.msh");
  auto text = small_scene();
  text.insert(text.find("[probe]"), "output = { sphere = { center_m = [0, 0, 0.1], radius_m = 0.01 } }\n");
  write_file(folder / "changed.toml", text);
  const auto outcome = be_refused("mesh changed.toml -o fresh/m.msh");
  EXPECT_NE(outcome.err.find("left as it was"), std::string::npos) << outcome.err;
  EXPECT_EQ(read_file(folder / "fresh/m.msh"), before);
}

TEST_F(Outputs, OfAnExportToParaViewAreAllOrNone) {
  succeed("show d.h5 --node " + node + " --direction 0 -o fresh/a.pvd");
  // In blocks of 512 bytes: less than a .vtu file.
  const auto size = fs::file_size(folder / "fresh/a-0001.vtu");
  fs::create_directory(folder / "part");
  ASSERT_GT(size, 1024u);
  const auto outcome = shell("ulimit -f " + std::to_string(size / 512 - 1) + "; \"$PHYNNESS\" show d.h5 --node " +
                             node + " --direction 0 -o part/a.pvd");
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  EXPECT_TRUE(fs::is_empty(folder / "part"));
}

TEST_F(Outputs, OfAModelNeverReplaceAnotherProgramsFiles) {
  fs::create_directory(folder / "foreign");
  for (const char* name : {"model.txt", "mesh.txt"}) {
    const auto file = folder / "foreign" / name;
    write_file(file, "notes of somebody");
    for (const char* line : {"train scene.toml d.h5 -o foreign", "calibrate model d.h5 -o foreign --rays 100",
                             "tune scene.toml d.h5 -o foreign --probes 2"}) {
      const auto outcome = be_refused(line);
      expect_error(outcome.err, {"a file that this program has not written", name, "give another folder"});
    }
    EXPECT_EQ(read_file(file), "notes of somebody");
    fs::remove(file);
  }
  succeed("train scene.toml d.h5 -o foreign");
  succeed("train scene.toml d.h5 -o foreign");  // a model is replaced
}

TEST_F(Outputs, OfARunNeverReplaceOtherFiles) {
  for (const char* name :
       {"mesh.msh", "mesh.json", "precompute.json", "check.json", "train.json", "calibrate.json", "validate.json",
        "stages.json", "organ.html", "model/model.txt", "model/mesh.txt", "model"}) {
    const auto file = folder / "fresh/out" / name;
    fs::create_directories(file.parent_path());
    write_file(file, "{\n  \"notes\": \"of somebody\"\n}\n");
    const auto before = read_file(file);
    for (const char* resume : {"", " --resume"}) {
      const auto outcome = be_refused(std::string("run scene.toml -o fresh/out") + resume);
      expect_error(outcome.err, {"--output fresh/out/" + std::string(name), "give another folder"});
      EXPECT_EQ(read_file(file), before);
    }
    fs::remove_all(folder / "fresh/out");
  }
  // The figures of another validation are nothing that this run has made.
  fs::create_directory(folder / "fresh/out");
  succeed("validate scene.toml model --probes 2 --json fresh/out/validate.json");
  be_refused("run scene.toml -o fresh/out");
  fs::remove(folder / "fresh/out/validate.json");
  for (const char* resume : {"", " --resume", " --resume"}) {
    succeed(std::string("run scene.toml -o fresh/out") + resume);
  }
}

// The networks have as many neurons as they may, so that each fit takes minutes. The limit ends a training that does
// not notice the signal.
TEST_F(Outputs, OfATrainingAreNotBegunWhenASignalEndsAFit) {
  auto text = small_scene("P1", 3);
  text.replace(text.find("target_size_m = 0.025"), 21, "target_size_m = 0.01");
  text.replace(text.find("samples = 500"), 13, "samples = 5000");
  write_file(folder / "scene.toml", text);
  succeed("precompute scene.toml -o many.h5");
  for (const char* signal : {"INT", "TERM"}) {
    const auto outcome = shell(
        "rm -f progress.txt; PHYNNESS_PROGRESS=1 timeout -s KILL 120 \"$PHYNNESS\" train scene.toml many.h5 -o "
        "fresh/model --family rbfn "
        "--neurons 100000 2>progress.txt & "
        "for i in $(seq 600); do grep -qs ' 0/' progress.txt && break; sleep 0.1; done; "
        "pkill -" +
        std::string(signal) + " -P $!; wait $!; status=$?; cat progress.txt >&2; exit $status");
    EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
    EXPECT_NE(outcome.err.find("error: training was interrupted\n  remedy: "), std::string::npos) << outcome.err;
    EXPECT_TRUE(fs::is_empty(folder / "fresh"));
  }
}

// What follows the last fit takes a tenth of a second here. A signal that comes after the end finds a model; then it is
// tried again.
TEST_F(Outputs, OfATrainingAreNotBegunWhenASignalComesAfterTheLastFit) {
  auto text = small_scene("P1", 1);
  const auto active = text.find("active = [");
  text.replace(active, text.find("[probe]") - active, "active = \"free-surface\"\n");
  text.replace(text.find("target_size_m = 0.025"), 21, "target_size_m = 0.015");
  text.replace(text.find("directions = 26"), 15, "directions = 3");
  text.replace(text.find("samples = 500"), 13, "samples = 300\nlevels = 8");
  write_file(folder / "scene.toml", text);
  succeed("precompute scene.toml -o many.h5");
  Outcome outcome;
  for (int attempt = 0; attempt < 10 && outcome.exit_status != 1; ++attempt) {
    fs::remove_all(folder / "fresh/model");
    outcome = shell(
        "rm -f progress.txt; PHYNNESS_PROGRESS=1 \"$PHYNNESS\" train scene.toml many.h5 -o fresh/model --family rbfn "
        "--neurons 150 "
        "--spread 0.75 2>progress.txt & pid=$!; "
        "while kill -0 $pid && ! grep -qsE ' ([0-9]+)/\\1 nodes' progress.txt; do sleep 0.01; done; sleep 0.02; "
        "kill -TERM $pid; wait $pid; status=$?; cat progress.txt >&2; exit $status");
  }
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  EXPECT_NE(outcome.err.find("error: training was interrupted\n  remedy: "), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "fresh/model"));
}

TEST_F(Outputs, OfARunEndWhenTheTerminalIsClosed) {
  auto text = small_scene("P1", 40);
  text.replace(text.find("target_size_m = 0.025"), 21, "target_size_m = 0.006");
  write_file(folder / "long.toml", text);
  // The run is ended once the database has begun; its child must not outlive it.
  const auto outcome = shell(
      "\"$PHYNNESS\" run long.toml -o out & pid=$!; "
      "for i in $(seq 600); do [ -e out/database.h5 ] && break; sleep 0.1; done; "
      "kill -HUP $pid; wait $pid; echo status $?; "
      "pgrep -f \"^$PHYNNESS precompute long.toml\" >left.txt; true");
  EXPECT_NE(outcome.out.find("status 1"), std::string::npos) << outcome.out << outcome.err;
  EXPECT_NE(outcome.err.find("interrupted in stage precompute"), std::string::npos) << outcome.err;
  EXPECT_EQ(read_file(folder / "left.txt"), "");
}

}  // namespace
}  // namespace phynness::test
