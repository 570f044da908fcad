// Files of a command. An output is never an input or another output; its place is looked at before the work begins,
// which may take hours; and the outputs are written independently of each other. Options declare their files when they
// are added. Files that become known later are declared before anything is written.
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

/// Applies the rule to all declared options of the command line. Files are identified by their canonical paths, also if
/// they or their folders do not exist yet. Pipes and devices may be named more than once. Also looks at the places of
/// all outputs. With --json -, texts for people go to stderr from here on.
/// @throws Error (input) if an output is an input or another output, or cannot be written: no folder, no permission, a
/// folder of that name, a text that another program has written in the place of a model's
void check_files();

/// Applies the rule to a file that no option names.
/// @param option  the option to which the file belongs, for messages; files of one option may be the same
/// @throws Error (input) if an output is an input or another output
void declare_input(const std::string& option, const std::filesystem::path& path);
void declare_output(const std::string& option, const std::filesystem::path& path, PathKind kind = PathKind::file);

/// Looks at the place of an output that is not declared. @throws Error (input) as check_files()
void check_place(const std::string& option, const std::filesystem::path& path, PathKind kind);

/// "-", which only --json takes: its JSON then goes to stdout, and the texts for people to stderr.
bool is_stdout(const std::filesystem::path& path);

/// Makes the folder of an output and all above it. @throws Error (input)
void make_folder(const std::filesystem::path& folder);

/// Writes every output, also after one that failed. Reports all failures.
/// @throws the last failure; those before are printed on stderr
void write_each(const std::vector<std::function<void()>>& outputs);

}  // namespace phynness::cli
