// Claim: an argument that is missing, too many, unknown or of a value that cannot be is an error like all others: exit
// status 2, the argument by its name as it was written, one remedy; of every subcommand.
#include "../pipeline/command_line.hpp"
#include "offered_options.hpp"

namespace phynness::test {
namespace {

class WrongOption : public CommandLine {
 protected:
  void expect_wrong(const std::string& arguments, const std::vector<std::string>& parts) {
    const auto outcome = be_refused(arguments);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.rfind("error: ", 0), 0u) << outcome.err;
    expect_error(outcome.err, parts);
  }
};

TEST_F(WrongOption, IsNamedAsItWasWritten) {
  expect_wrong("eval", {"MODEL_DIR", "phynness eval --help"});
  expect_wrong("train a b", {"--output", "phynness train --help"});
  expect_wrong("train a b --ouput c", {"--output", "--ouput c"});
  expect_wrong("validate a b --max-error 2", {"--max-error 2", "phynness validate --help"});
  expect_wrong("validate a b c d", {"c d"});
  expect_wrong("plan s --ranks 64x", {"--ranks", "64x", "1000000", "phynness plan --help"});
  expect_wrong("train a b -o c --family x", {"--family", "x", "modal"});
  expect_wrong("eval m --node", {"--node"});
  expect_wrong("eval m --node x", {"--node", "x"});
  expect_wrong("", {"subcommand", "phynness --help"});
  expect_wrong("--bogus", {"subcommand", "--bogus"});
}

TEST_F(WrongOption, OfEverySubcommandIsAnErrorWithARemedy) {
  const auto subcommands = offered_options(phynness("--help").out).subcommands;
  EXPECT_GE(subcommands.size(), 8u);
  for (const auto& subcommand : subcommands) expect_wrong(subcommand + " --no-such-option", {"--no-such-option"});
}

TEST_F(WrongOption, IsNotTheCallForHelpOrVersion) {
  for (const char* call : {"--help", "--version", "eval --help"}) {
    const auto outcome = succeed(call);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

// The program appends to the names of its outputs and makes files in its folders: without the check a command would
// fail after all of its work. The error names what is allowed, so that nobody has to try twice.
TEST_F(WrongOption, IsANameThatIsTooLong) {
  write_file(folder / "s.toml", "");
  const std::regex limits("a name of at most ([0-9]+) bytes, in a path of at most ([0-9]+)\n");
  for (const std::string line : {"precompute s.toml --part 1/2147483647 -o @", "train s.toml d.h5 -o @",
                                 "run s.toml -o @", "show d.h5 --node 1 --direction 0 -o @.pvd", "info @"}) {
    const bool output = line.find("-o @") != std::string::npos;
    const auto with = [&](const std::string& name) { return std::string(line).replace(line.find('@'), 1, name); };
    const std::string ending = line.ends_with(".pvd") ? ".pvd" : "", folders = [] {
      std::string text;
      for (int i = 0; i < 50; ++i) text += std::string(99, 'a') + "/";
      return text;
    }();
    for (const auto& given : {std::string(output ? 247 : 256, 'a'), std::string(5000, 'a'), folders + "a"}) {
      SCOPED_TRACE(line + " " + given.substr(0, 4) + " " + std::to_string(given.size()));
      expect_wrong(with(given), {"too long"});
      const auto said = phynness(with(given)).err;
      std::smatch most;
      ASSERT_TRUE(std::regex_search(said, most, limits)) << said;
      const std::size_t name = std::stoul(most[1]), path = std::stoul(most[2]);
      const auto longest = std::string(name - ending.size(), 'b');
      // A name and a path of these lengths: the error is about the scene or the database.
      const auto in_folders = path - folder.string().size() - 1;
      const auto allowed = be_refused(with(folders.substr(0, (in_folders - name) / 100 * 100) + longest));
      EXPECT_EQ(allowed.err.find("too long"), std::string::npos) << allowed.err;
    }
  }
}

// Under mpirun every rank would do the whole work and write the same files.
TEST_F(WrongOption, IsMpirunForACommandThatWorksAlone) {
  for (const std::string line :
       {"run a -o b", "import a -o b", "train a b -o c", "mesh a -o b", "view a -o b", "export a -o b",
        "eval a --node 1 --displacement 0,0,0", "info a", "bench a", "tune a b -o c", "check a", "plan a",
        "solve a --node 1 --displacement 0,0,0", "show a --node 1 --direction 0 -o b.vtu"}) {
    const auto first = shell("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 \"$PHYNNESS\" " + line);
    EXPECT_EQ(first.exit_status, 2) << line << first.err;
    expect_error(first.err, {line.substr(0, line.find(' ')) + " must run as one process", "2 ranks", "mpirun"});
  }
  // These divide their work; the error is about the files.
  for (const char* line : {"precompute a -o b", "calibrate a b -o c", "validate a b"})
    EXPECT_EQ(shell("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 \"$PHYNNESS\" " + std::string(line))
                  .err.find("must run as one process"),
              std::string::npos)
        << line;
}

}  // namespace
}  // namespace phynness::test
