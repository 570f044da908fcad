#include "command_files.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/schema/text_reader.hpp>

#include "console.hpp"

namespace phynness::cli {
namespace {

namespace fs = std::filesystem;

/// A file that the command reads or writes.
struct FileUse {
  std::string option;
  fs::path path, canonical;  ///< path of the command line, and its canonical form
  bool written = false;
};

/// All files of the command of this process.
std::vector<FileUse>& file_uses() {
  static std::vector<FileUse> all;
  return all;
}

std::vector<std::pair<const CLI::Option*, PathKind>>& declared_options() {
  static std::vector<std::pair<const CLI::Option*, PathKind>> all;
  return all;
}

/// The text files of a model with their first words.
constexpr std::pair<const char*, std::string_view> model_texts[] = {{"model.txt", schema::model_magic},
                                                                    {"mesh.txt", mesh_text_magic}};

fs::path place_of(const fs::path& path) {
  std::error_code code;
  const auto absolute = fs::absolute(path, code);
  const auto found = fs::weakly_canonical(absolute, code);
  return code ? absolute.lexically_normal() : found;
}

void add_file_use(const std::string& option, const fs::path& path, bool written) {
  std::error_code code;
  if (fs::is_other(path, code)) return;  // pipes, terminals and /dev/null have no content
  const FileUse use{option, path, place_of(path), written};
  for (const auto& other : file_uses()) {
    if (use.canonical != other.canonical || option == other.option || !(written || other.written)) continue;
    const auto &output = written ? use : other, &second = written ? other : use;
    throw input_error(
        fmt::format("an output would overwrite {}", second.written ? "another output" : "an input"),
        fmt::format("{} {} and {} {}", output.option, output.path.string(), second.option, second.path.string()),
        fmt::format("give {} another file or directory", output.option));
  }
  file_uses().push_back(use);
}

void add_path_use(const std::string& option, const fs::path& path, PathKind kind) {
  std::error_code code;
  const bool written = kind != PathKind::input;
  if (kind != PathKind::folder) add_file_use(option, path, written);
  if (kind == PathKind::model || (!written && fs::is_directory(path, code)))
    for (const auto& [name, first_line] : model_texts) add_file_use(option, path / name, written);
}

Error cannot_write(const std::string& option, const fs::path& path, const std::string& why, const std::string& remedy) {
  return input_error("an output cannot be written: " + why, option + " " + path.string(), remedy);
}

/// @param is_created  whether the command creates a missing folder
void check_folder(const std::string& option, const fs::path& path, fs::path folder, bool is_created) {
  std::error_code code;
  while (is_created && !fs::exists(folder, code) && folder.has_relative_path()) folder = folder.parent_path();
  if (!fs::is_directory(folder, code))
    throw cannot_write(option, path, folder.string() + (fs::exists(folder, code) ? " is a file" : " is no folder"),
                       fs::exists(folder, code) ? "give another place" : "make the folder, or give another place");
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw cannot_write(option, path, "the folder " + folder.string() + " is not writable",
                       "change its permissions, or give another place");
}

/// @throws Error (input) if a file with other first words exists, which would be lost
void check_text_header(const std::string& option, const fs::path& file, std::string_view first_line) {
  std::error_code code;
  if (!fs::exists(file, code)) return;
  std::string text(first_line.size(), '\0');
  std::ifstream(file, std::ios::binary).read(text.data(), std::ssize(text));
  if (text != first_line)
    throw cannot_write(option, file, "a file that this program has not written has this name",
                       "give another folder, or move the file");
}

/// @return false for --json -, which is not a file. @throws Error (input)
bool is_file_option(const std::string& option, const fs::path& path, PathKind kind) {
  if (path.empty()) throw input_error("the name of a file is empty", option + " ''", "give the name of a file");
  if (kind == PathKind::input || !is_stdout(path)) return true;
  if (option != "--json")
    throw input_error("only --json can be written to stdout", option + " -",
                      "give ./- for a file of this name, or another name");
  print_results_on_stderr();
  return false;
}

}  // namespace

void declare(CLI::Option& option, PathKind kind) {
  option.type_name(kind == PathKind::input ? "INPUT" : "OUTPUT");
  declared_options().emplace_back(&option, kind);
}

void check_files() {
  for (const auto& [option, kind] : declared_options())
    for (const auto& path : option->results()) {
      if (!is_file_option(option->get_name(), path, kind)) continue;
      add_path_use(option->get_name(), path, kind);
      check_place(option->get_name(), path, kind);
    }
}

void declare_input(const std::string& option, const fs::path& path) { add_path_use(option, path, PathKind::input); }
void declare_output(const std::string& option, const fs::path& path, PathKind kind) {
  add_path_use(option, path, kind);
}

void check_place(const std::string& option, const fs::path& path, PathKind kind) {
  std::error_code code;
  // DatabaseWriter looks at the folder itself.
  if (kind == PathKind::input || kind == PathKind::database) return;
  if (kind == PathKind::file) {
    if (fs::is_directory(path, code)) throw cannot_write(option, path, "this is a folder", "give the name of a file");
    if (!fs::is_other(path, code)) check_folder(option, path, place_of(path).parent_path(), false);
    return;
  }
  check_folder(option, path, place_of(path), true);
  if (kind != PathKind::model) return;
  for (const auto& [name, first_line] : model_texts) check_text_header(option, path / name, first_line);
}

bool is_stdout(const fs::path& path) { return path == "-"; }

void make_folder(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code)
    throw input_error("the output folder cannot be made", folder.string() + ": " + code.message(),
                      "give a folder in a place where you may write");
}

void write_each(const std::vector<std::function<void()>>& outputs) {
  std::optional<Error> last;
  for (const auto& write : outputs) try {
      write();
    } catch (const Error& error) {
      if (last) message("error: {}\n", last->what());
      last = error;
    }
  if (last) throw Error(*last);
}

}  // namespace phynness::cli
