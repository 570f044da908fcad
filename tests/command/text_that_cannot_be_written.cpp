// Claims: text that cannot be written to stderr is lost without other effects. If results cannot be written to stdout,
// this is reported on stderr after all files were written, with exit status 1. No printed text gets into a file, even
// if standard descriptors are closed at the start.
#include <regex>

#include "../pipeline/command_line.hpp"

namespace phynness::test {
namespace {

namespace fs = std::filesystem;

class UnwritableText : public CommandLine {
 protected:
  void SetUp() override {
    CommandLine::SetUp();
    // Something to say on stderr: progress as on a terminal, and a warning, as this element locks.
    setenv("PHYNNESS_PROGRESS", "1", 1);
    auto text = small_scene();
    text.replace(text.find("0.45"), 4, "0.49");
    write_file(folder / "scene.toml", text);
    EXPECT_NE(phynness("mesh scene.toml -o scene.msh").err, "");
    succeed("precompute scene.toml -o whole.h5");
    succeed("train scene.toml whole.h5 -o whole");
    succeed("info whole.h5 --json whole.json");
  }
  void TearDown() override {
    unsetenv("PHYNNESS_PROGRESS");
    CommandLine::TearDown();
  }

  /// A precompute and a training with this redirection of their streams end with this status, and completely.
  void expect_complete(const std::string& redirection, int status) {
    for (const char* left : {"d.h5", "d.h5.log", "m"}) fs::remove_all(folder / left);
    const auto outcome = shell("( \"$PHYNNESS\" precompute scene.toml -o d.h5 --json d.json ) " + redirection +
                               "; echo $? >status1; ( \"$PHYNNESS\" train scene.toml whole.h5 -o m --json m.json ) " +
                               redirection + "; echo $? >status2");
    for (const char* name : {"status1", "status2"})
      EXPECT_EQ(read_file(folder / name), std::to_string(status) + "\n") << redirection << "\n" << outcome.err;
    succeed("info d.h5 --json info.json");
    auto made = json("info.json"), whole = json("whole.json");
    for (auto* info : {&made, &whole}) info->at("quantities").erase("seconds");  // of the processor
    EXPECT_EQ(made, whole) << redirection;
    for (const char* name : {"model.txt", "mesh.txt"})
      EXPECT_EQ(read_file(folder / "m" / name), read_file(folder / "whole" / name)) << redirection;
    for (const char* name : {"d.json", "m.json"}) EXPECT_TRUE(json(name).is_object()) << redirection;
  }

  /// With a reader that has closed its end before the command starts.
  std::string status_with_closed_pipe(const std::string& words) {
    for (const char* left : {"closed", "status"}) fs::remove(folder / left);
    shell("{ while [ ! -e closed ]; do sleep 0.01; done; \"$PHYNNESS\" " + words +
          "; echo $? >status; } | { exec <&-; : >closed; sleep 0.01; }; while [ ! -s status ]; do sleep "
          "0.01; done");
    return read_file(folder / "status");
  }
};

TEST_F(UnwritableText, OnStderrChangesNothing) {
  for (const char* redirection : {"2>/dev/full", "2>&-", "<&- 2>&-"}) expect_complete(redirection, 0);
  // Why it ends is lost as well, and the exit status is the same.
  write_file(folder / "bad.toml", "nonsense = 1\n");
  for (const char* redirection : {"2>/dev/full", "2>&-"}) {
    be_refused(std::string("mesh bad.toml -o bad.msh ") + redirection);
    be_refused(std::string("mesh --no-such-option ") + redirection);
  }
}

TEST_F(UnwritableText, OnStdoutIsReportedWhenTheWorkIsDone) {
  for (const char* redirection : {">/dev/full", ">&-", ">/dev/full 2>/dev/full", "<&- >&- 2>&-"})
    expect_complete(redirection, 1);
  for (const char* words : {"--help", "--version", "mesh --help", "info whole", "info scene.toml", "bench whole"})
    for (const char* redirection : {" >/dev/full", " >&-"}) {
      const auto outcome = phynness(std::string(words) + redirection);
      EXPECT_EQ(outcome.exit_status, 1) << words << redirection;
      expect_names(outcome.err, {"error: ", "stdout", "\n  remedy: "});
      EXPECT_EQ(outcome.err.find("PETSC"), std::string::npos) << outcome.err;
    }
}

TEST_F(UnwritableText, InAClosedPipeIsAFailureLikeOthers) {
  EXPECT_EQ(status_with_closed_pipe("info whole"), "1\n");
  EXPECT_EQ(status_with_closed_pipe("train scene.toml whole.h5 -o piped"), "1\n");
  EXPECT_EQ(read_file(folder / "piped/model.txt"), read_file(folder / "whole/model.txt"));
}

TEST_F(UnwritableText, EndsNoStageOfARun) {
  for (const char* redirection : {" >/dev/full", " >&-", " >/dev/full 2>/dev/full", " 2>&-"}) {
    fs::remove_all(folder / "out");
    const auto run = phynness(std::string("run scene.toml -o out") + redirection);
    EXPECT_EQ(run.exit_status, std::string(redirection) == " 2>&-" ? 0 : 1) << redirection << "\n" << run.err;
    EXPECT_TRUE(fs::exists(folder / "out/validate.json")) << redirection;
    // Told once, by the command that was started.
    const std::string told = "written to stdout";
    EXPECT_EQ(run.err.find(told), run.err.rfind(told)) << run.err;
  }
}

TEST(Text, IsPrintedInOnePlace) {
  // What throws or aborts where a stream cannot be written is in no source of the command and its libraries.
  const std::regex printing(R"((fmt::(v?print|vprint)\(|std::(cout|cerr|clog)\b|\bstd::(printf|puts|putchar)\())");
  int sources = 0;
  for (const char* part : {"cli", "embedding", "evaluation", "formats", "meshes", "planning", "precompute_dolfinx",
                           "runtime", "training", "tuning", "validation"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PHYNNESS_SOURCE_DIR) / part)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp" && extension != ".h") continue;
      ++sources;
      std::istringstream lines(read_file(entry.path()));
      int number = 0;
      for (std::string line; std::getline(lines, line);)
        if (++number; std::regex_search(line, printing))
          ADD_FAILURE() << entry.path().string() << ":" << number << ": use cli/streams.hpp: " << line;
    }
  EXPECT_GT(sources, 100);
}

}  // namespace
}  // namespace phynness::test
