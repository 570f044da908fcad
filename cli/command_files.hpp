// Input and output files of a command, and the rule that an output never overwrites an input or another output. Options
// declare their files when they are added. Files that become known later are declared before anything is written.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace phynness::cli {

enum class InputKind {
  whole,  ///< a file, together with the logs of a database in FILE.log/; or a directory with all its files
  folder  ///< a directory; the command declares separately the files in it that it reads
};
enum class OutputKind {
  file,
  database,  ///< FILE, and FILE.log/ with all its files
  model,     ///< a directory with model.txt and mesh.txt
  folder,    ///< a directory; the command declares separately the files in it that it writes
  tree       ///< a directory with all its files
};

void declare(CLI::Option& option, InputKind kind);
void declare(CLI::Option& option, OutputKind kind);

/// Adds an option for a path. --help shows its value as INPUT or OUTPUT.
template <class Kind, class Value>
CLI::Option* add_path(CLI::App& command, const std::string& name, Value& value, Kind kind, const std::string& what) {
  auto* option = command.add_option(name, value, what);
  declare(*option, kind);
  return option;
}

/// Applies the rule to all declared options of the command line. Files are identified by their canonical paths, also if
/// they or their folders do not exist yet, and by device and inode. Pipes and devices may be named more than once. Also
/// looks at the places of all outputs, so that work of hours does not end at a folder that is not there. With --json -,
/// texts for people go to stderr from here on.
/// @throws Error (input) if an output equals, contains or lies in an input or another output, or cannot be written
void check_files(const CLI::App& app);

/// Applies the rule to a file that no option names.
/// @param option  the option to which the file belongs, for messages; files of one option may be the same
/// @throws Error (input) as check_files()
void declare_input(const std::string& option, const std::filesystem::path& path);
void declare_output(const std::string& option, const std::filesystem::path& path, OutputKind kind = OutputKind::file);

}  // namespace phynness::cli
