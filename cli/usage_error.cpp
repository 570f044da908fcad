#include "usage_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace phynness::cli {
namespace {

/// "MODEL_DIR is required", which is what CLI11 says, without the last two words; "" if it says something else.
std::string missing_name(const CLI::ParseError& error) {
  constexpr std::string_view end = " is required";
  const std::string_view text = error.what();
  if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::RequiredError) || !text.ends_with(end)) return "";
  return std::string(text.substr(0, text.size() - end.size()));
}

}  // namespace

Error usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const auto commands = app.get_subcommands();
  const std::string command = commands.empty() ? "phynness" : "phynness " + commands.back()->get_name();
  const auto extras = app.remaining(true);
  // A wrong name for a required option is one missing option and two words too many: both are said.
  const auto extra_words = fmt::format("{}", fmt::join(extras, " "));
  const auto missing = missing_name(error);
  if (missing == "A subcommand") {
    return input_error("a subcommand is missing", extras.empty() ? "" : "not known: " + extra_words,
                       "phynness --help lists the subcommands");
  }
  if (!missing.empty()) {
    return input_error("an argument is missing", missing + (extras.empty() ? "" : " (not known: " + extra_words + ")"),
                       fmt::format("add {}; {} --help describes it", missing, command));
  }
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    return input_error(command + " has no such option, or takes fewer arguments", extra_words,
                       command + " --help lists its arguments and options");
  }
  return input_error("the command line cannot be used", error.what(),
                     command + " --help lists the options and the values that they take");
}

}  // namespace phynness::cli
