// Claims: a command overwrites no input, and `run` no file at all without --resume. On a full disk no output remains
// half, and the others are written. A signal ends a training before it has written anything. --json - writes JSON alone
// to stdout, and results that stdout does not take cost no file. Every option for a path is declared.
#include <set>

#include "../pipeline/command_line.hpp"
#include "offered_options.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

class Outputs : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    write_file(folder / "scene.toml", small_scene());
    fs::create_directory(folder / "fresh");
    make_once({"precompute scene.toml -o d.h5", "train scene.toml d.h5 -o model"});
    node = std::to_string(active_of("d.h5").at(0));
  }
  std::string eval() const { return "eval model --node " + node + " --displacement 0,0,-0.001 "; }
  std::string node;
};

TEST_F(Outputs, OverwriteNoInput) {
  const auto scene = read_file(folder / "scene.toml"), model = read_file(folder / "model/model.txt");
  expect_error(be_refused("train scene.toml d.h5 -o fresh/m --json ./scene.toml").err, {"would overwrite", "--json"});
  expect_error(be_refused(eval() + "--json model/model.txt").err, {"would overwrite", "--json"});
  expect_error(be_refused("precompute scene.toml -o d.h5").err, {"exists", "--resume"});
  EXPECT_EQ(read_file(folder / "scene.toml"), scene);
  EXPECT_EQ(read_file(folder / "model/model.txt"), model);
  EXPECT_TRUE(fs::is_empty(folder / "fresh"));
}

TEST_F(Outputs, OfARunReplaceNothing) {
  fs::create_directory(folder / "out");
  write_file(folder / "out/mesh.json", "of somebody");
  expect_error(be_refused("run scene.toml -o out").err, {"would replace", "out/mesh.json"});
  EXPECT_EQ(read_file(folder / "out/mesh.json"), "of somebody");
  fs::remove(folder / "out/mesh.json");
  succeed("run scene.toml -o out");
  const auto before = read_file(folder / "out/model/model.txt");
  write_file(folder / "other.toml", changed(small_scene(), "0.05]", "0.06]"));
  for (const char* line : {"run other.toml -o out", "run other.toml -o out --resume", "run scene.toml -o out"})
    expect_names(be_refused(line).err, {"out/database.h5"});
  EXPECT_EQ(read_file(folder / "out/model/model.txt"), before);
}

TEST_F(Outputs, ThatFailCostNoOthers) {
  const auto written = phynness(eval() + "--deformation /dev/full --json fresh/ok.json");
  EXPECT_EQ(written.exit_status, 1);
  expect_names(written.err, {"writing failed: /dev/full"});
  EXPECT_TRUE(json("fresh/ok.json").contains("tools"));
}

TEST_F(Outputs, OfAModelAreWholeOrAbsentOnAFullDisk) {
  const auto mesh = fs::file_size(folder / "model/mesh.txt"), model = fs::file_size(folder / "model/model.txt");
  ASSERT_GT(model, mesh + 1024);
  // In blocks of 512 bytes: mesh.txt fits, model.txt does not.
  const auto limit = "ulimit -f " + std::to_string(mesh / 512 + 1) + "; \"$PHYNNESS\" ";
  EXPECT_EQ(shell(limit + "train scene.toml d.h5 -o half").exit_status, 1);
  EXPECT_TRUE(fs::is_empty(folder / "half"));
}

TEST_F(Outputs, OfADatabaseAreWholeOrAbsentOnAFullDisk) {
  // 120 blocks of 512 bytes. Open MPI would make larger files.
  const auto outcome =
      shell("export OMPI_MCA_ess_singleton_isolated=1; ulimit -f 120; \"$PHYNNESS\" precompute scene.toml -o e.h5");
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  expect_error(outcome.err, {"cannot write", "e.h5", "free space"});
}

TEST_F(Outputs, OfTheFormatJsonGoToStdout) {
  for (const auto& line : {std::string("info d.h5 "), eval(), std::string("mesh scene.toml -o fresh/m.msh ")}) {
    const auto outcome = succeed(line + "--json -");
    EXPECT_TRUE(nlohmann::json::parse(outcome.out, nullptr, false).is_object()) << line << "\n" << outcome.out;
  }
  expect_error(be_refused("mesh scene.toml -o -").err, {"--output -", "./-"});
}

TEST_F(Outputs, AreWrittenIfStdoutTakesNothing) {
  for (const char* redirection : {" >/dev/full", " >&-"}) {
    fs::remove(folder / "fresh/ok.json");
    const auto outcome = phynness(eval() + "--json fresh/ok.json" + redirection);
    EXPECT_EQ(outcome.exit_status, 1) << redirection;
    expect_error(outcome.err, {"stdout"});
    EXPECT_TRUE(json("fresh/ok.json").contains("tools"));
  }
  EXPECT_EQ(phynness(eval() + "2>/dev/full").exit_status, 0);
}

// The networks have as many neurons as they may, so that each fit takes minutes. The limit ends a training that does
// not notice the signal.
TEST_F(Outputs, OfATrainingAreNotBegunWhenASignalEndsAFit) {
  const auto text = changed(small_scene("P1", 3), "target_size_m = 0.025", "target_size_m = 0.01");
  write_file(folder / "scene.toml", changed(text, "samples = 500", "samples = 5000"));
  succeed("precompute scene.toml -o many.h5");
  const auto outcome = shell(
      "PHYNNESS_PROGRESS=1 timeout -s KILL 120 \"$PHYNNESS\" train scene.toml many.h5 -o fresh/model --family rbfn "
      "--set deformation_neurons=100000 --set force_neurons=100000 2>progress.txt & "
      "for i in $(seq 600); do grep -qs ' 0/' progress.txt && break; sleep 0.1; done; "
      "pkill -INT -P $!; wait $!; status=$?; cat progress.txt >&2; exit $status");
  EXPECT_EQ(outcome.exit_status, 1) << outcome.err;
  expect_names(outcome.err, {"error: training was interrupted"});
  EXPECT_TRUE(fs::is_empty(folder / "fresh"));
}

/// Texts that are not names of files. A new option that names a file is declared, with add_path() of
/// cli/command_files.hpp.
const std::set<std::string> texts{"--part",      "--displacement", "--point",       "--tools",
                                  "--family",    "--max-error",    "--max-time",    "--name",
                                  "--reference", "--set",          "--target-error"};

TEST_F(Outputs, OfEveryOptionAreDeclared) {
  for (const auto& command : offered_options(succeed("--help").out).subcommands)
    for (const auto& option : offered_options(succeed(command + " --help").out).of_type("TEXT"))
      EXPECT_TRUE(texts.contains(option.name))
          << command << " " << option.name << ": declare it with add_path(), or list it here as a plain text";
}

}  // namespace
}  // namespace phynness::test
