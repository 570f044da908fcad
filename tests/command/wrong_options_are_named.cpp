// Claim: an argument that is missing, too many, unknown or of a value that cannot be is an error like all others: exit
// status 2, the argument by its name as it was written, one remedy; of every subcommand.
#include "../pipeline/command_line.hpp"
#include "offered_options.hpp"

namespace phynness::test {
namespace {

class WrongOption : public CommandLine {
 protected:
  void expect_wrong(const std::string& arguments, const std::vector<std::string>& parts) {
    const auto outcome = phynness(arguments);
    EXPECT_EQ(outcome.exit_status, 2) << arguments;
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
    const auto outcome = phynness(call);
    EXPECT_EQ(outcome.exit_status, 0) << call;
    EXPECT_NE(outcome.out, "");
    EXPECT_EQ(outcome.err, "");
  }
}

}  // namespace
}  // namespace phynness::test
