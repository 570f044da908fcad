// Claim: an argument that is missing, too many, unknown or of a value that cannot be is an error like all others: exit
// status 2, the argument by its name as it was written, one remedy.
#include "../pipeline/command_line.hpp"

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
  for (const auto& [option, value] : {std::pair{"--seed", "-1"}, {"--ranks", "nan"}, {"--rays", "1s"}})
    expect_wrong(std::string("plan s ") + option + " " + value, {option, value});
  expect_wrong("mesh s -o ''", {"--output"});
  expect_wrong("prcompute s -o d.h5", {"prcompute"});
  expect_wrong("train a b -o c --family x", {"--family", "x", "modal"});
  expect_wrong("eval m --node", {"--node"});
  expect_wrong("eval m --node x", {"--node", "x"});
  expect_wrong("", {"subcommand", "phynness --help"});
  expect_wrong("--bogus", {"subcommand", "--bogus"});
}

TEST_F(WrongOption, IsNotTheCallForHelpOrVersion) {
  for (const char* call : {"--help", "--version", "eval --help"}) {
    const auto outcome = succeed(call);
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

// Under mpirun every rank would do the whole work and write the same files.
TEST_F(WrongOption, IsMpirunForACommandThatWorksAlone) {
  for (const std::string line : {"run a -o b", "train a b -o c"}) {
    const auto first = shell("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 \"$PHYNNESS\" " + line);
    EXPECT_EQ(first.exit_status, 2) << line << first.err;
    expect_error(first.err, {line.substr(0, line.find(' ')) + " must run as one process", "2 ranks", "mpirun"});
  }
  EXPECT_EQ(shell("OMPI_COMM_WORLD_SIZE=2 OMPI_COMM_WORLD_RANK=0 \"$PHYNNESS\" validate a b")
                .err.find("must run as one process"),
            std::string::npos);
}

}  // namespace
}  // namespace phynness::test
