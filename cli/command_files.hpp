// The files of a command. An output is never an input or another output. Its place is checked before the work begins,
// which may take hours. The outputs are written independently of each other. Options declare their files when they are
// added; files that become known later are declared before anything is written.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace phynness::cli {

enum class PathKind {
  input,     ///< a file, or a directory with model.txt and mesh.txt
  file,      ///< an output, first written to FILE.part
  database,  ///< an output
  model,     ///< an output: a directory with model.txt and mesh.txt
  folder     ///< an output: a directory; the command declares separately the files in it that it writes
};

void declare(CLI::Option& option, PathKind kind);

/// Adds an option for a path. --help shows its value as INPUT or OUTPUT.
template <class Value>
CLI::Option* add_path(CLI::App& command, const std::string& name, Value& value, PathKind kind,
                      const std::string& what) {
  auto* option = command.add_option(name, value, what);
  declare(*option, kind);
  return option;
}

/// Checks all declared options of the command line, and the places of all outputs. Files are identified by canonical
/// paths, even if they or their folders do not exist yet. Pipes and devices may be named more than once. With --json -,
/// later texts for people go to stderr.
/// @throws Error (input) if an output is an input or another output, or cannot be written: no folder, no permission, a
/// folder of that name, a text that another program has written in the place of a model's
void check_files();

/// Checks a file that no option names.
/// @param option  the option to which the file belongs, for messages; files of one option may be the same
/// @throws Error (input) if an output is an input or another output
void declare_input(const std::string& option, const std::filesystem::path& path);
void declare_output(const std::string& option, const std::filesystem::path& path, PathKind kind = PathKind::file);

/// Checks the place of an output that is not declared. @throws Error (input) as check_files()
void check_place(const std::string& option, const std::filesystem::path& path, PathKind kind);

/// Whether the path is "-", which only --json accepts; JSON then goes to stdout, and texts for people go to stderr.
bool is_stdout(const std::filesystem::path& path);

/// Creates the folder of an output and its parents. @throws Error (input)
void make_folder(const std::filesystem::path& folder);

/// Writes every output, also after a failure.
/// @throws the last failure; earlier ones are printed on stderr
void write_each(const std::vector<std::function<void()>>& outputs);

}  // namespace phynness::cli
