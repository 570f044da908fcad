// The subcommands and their options, as --help prints them.
#pragma once

#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace phynness::test {

struct OfferedOption {
  std::string name;                         ///< "--json", or "SCENE" of a positional one
  std::string type;                         ///< "INPUT", "OUTPUT", "TEXT", ...; empty: a flag
  bool required = false, excludes = false;  ///< excludes: other options
};

struct Offered {
  std::vector<std::string> subcommands;
  std::vector<OfferedOption> options;

  std::vector<OfferedOption> of_type(const std::string& type) const {
    std::vector<OfferedOption> found;
    for (const auto& option : options)
      if (option.type == type) found.push_back(option);
    return found;
  }
};

inline Offered offered_options(const std::string& help) {
  static const std::regex option(R"(^  (?:-[A-Za-z],)?(--[A-Za-z0-9-]+)(?: ([A-Z]+)(?=[^A-Za-z]|$))?.*)"),
      positional(R"(^  ([A-Z_]+) ([A-Z]+).*)"), subcommand(R"(^  ([a-z]+)(?: .*|$))");
  Offered found;
  std::istringstream lines(help);
  std::string section;
  std::smatch word;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line[0] != ' ' && line.back() == ':') section = line;
    const bool required = line.find(" REQUIRED") != std::string::npos;
    if (section == "Subcommands:") {
      if (std::regex_match(line, word, subcommand)) found.subcommands.push_back(word[1]);
    } else if (section == "Positionals:") {
      if (std::regex_match(line, word, positional)) found.options.push_back({word[1], word[2], required});
    } else if (std::regex_match(line, word, option)) {
      found.options.push_back({word[1], word[2], required, line.find(" Excludes: ") != std::string::npos});
    }
  }
  return found;
}

}  // namespace phynness::test
