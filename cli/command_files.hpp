// Which files a command reads and writes, and the one rule for all of them: an output never overwrites an
// input or another output. Options declare their files as they are added; what is known later is declared
// before anything is written.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace phynness::cli {

enum class InputKind {
  whole,  ///< a file, with the logs of a database in FILE.log/; or a directory and everything in it
  folder  ///< a directory; the command declares which files in it it reads
};
enum class OutputKind {
  file,
  database,  ///< FILE, and FILE.log/ with everything in it
  model,     ///< a directory, with model.txt and mesh.txt
  folder,    ///< a directory; the command declares which files in it it writes
  tree       ///< a directory and everything in it
};

void declare(CLI::Option& option, InputKind kind);
void declare(CLI::Option& option, OutputKind kind);

/// Adds an option for a path. --help calls its value INPUT or OUTPUT.
template <class Kind, class Value>
CLI::Option* add_path(CLI::App& command, const std::string& name, Value& value, Kind kind, const std::string& what) {
  auto* option = command.add_option(name, value, what);
  declare(*option, kind);
  return option;
}

/// Applies the rule to all declared options that are given. A file is known by its canonical path, also where
/// it or its folder does not exist yet, and by device and inode. Pipes and devices may be named more than
/// once.
/// @throws Error (input) if an output is, holds or lies in an input or another output
void check_files(const CLI::App& app);

/// Applies the rule to what no option names.
/// @param option  whose it is, for messages; files of one option may be the same
/// @throws Error (input) as check_files()
void declare_input(const std::string& option, const std::filesystem::path& path);
void declare_output(const std::string& option, const std::filesystem::path& path, OutputKind kind = OutputKind::file);

}  // namespace phynness::cli
