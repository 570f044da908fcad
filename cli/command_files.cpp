#include "command_files.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/schema/text_reader.hpp>
#include <tuple>

#include "console.hpp"

namespace phynness::cli {
namespace {

namespace fs = std::filesystem;

/// A file or directory that the command reads or writes.
struct Claim {
  std::string option;
  fs::path given, path;  ///< as the user gives it, and canonical
  bool written = false;
  bool encloses = true;  ///< no other claim may lie inside; also true for files
};

/// All claims of the command that this process runs.
std::vector<Claim>& claims() {
  static std::vector<Claim> all;
  return all;
}

std::vector<std::pair<const CLI::Option*, PathKind>>& declared_options() {
  static std::vector<std::pair<const CLI::Option*, PathKind>> all;
  return all;
}

fs::path place_of(const fs::path& path) {
  std::error_code code;
  const auto absolute = fs::absolute(path, code);
  auto found = fs::weakly_canonical(absolute, code);
  if (code) found = absolute.lexically_normal();
  return found.has_filename() ? found : found.parent_path();  // without the slash at the end
}

/// The place itself or one below it.
bool lies_in(const fs::path& inner, const fs::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

/// Pipes, terminals and /dev/null hold no data that could be overwritten.
bool keeps_nothing(const fs::path& path) {
  std::error_code code;
  return fs::is_other(path, code);
}

/// The program appends to names of outputs and makes files in its folders: without this a command would fail after all
/// of its work. @throws Error (input) that names both limits
void check_length(const std::string& option, const fs::path& path, bool written) {
  // Longer than .grown.log/rank-2147483647-0000 and than all that is made in a folder.
  const std::string added(written ? 64 : 0, 'x');
  std::error_code code;
  for (const auto& tried : {path.filename(), path}) {
    static_cast<void>(fs::exists(tried.string() + added, code));
    if (code == std::errc::filename_too_long)
      throw input_error("the name or the path of a file is too long",
                        fmt::format("{} {}: {} bytes", option, shortened(path.string(), 60), tried.native().size()),
                        fmt::format("give a name of at most {} bytes, in a path of at most {}", NAME_MAX - added.size(),
                                    PATH_MAX - 1 - added.size()));
  }
}

void add_claim(Claim claim) {
  if (keeps_nothing(claim.given)) return;
  claim.path = place_of(claim.given);
  for (const auto& other : claims()) {
    if (!(claim.written || other.written) || claim.option == other.option) continue;
    if (!(other.encloses && lies_in(claim.path, other.path)) && !(claim.encloses && lies_in(other.path, claim.path)))
      continue;
    const auto &output = claim.written ? claim : other, &second = claim.written ? other : claim;
    throw input_error(
        fmt::format("an output would overwrite {}", second.written ? "another output" : "an input"),
        fmt::format("{} {} and {} {}", output.option, output.given.string(), second.option, second.given.string()),
        fmt::format("give {} another file or directory", output.option));
  }
  claims().push_back(std::move(claim));
}

/// The texts of a model, with their beginnings.
constexpr std::pair<const char*, std::string_view> model_texts[] = {{"model.txt", schema::model_magic},
                                                                    {"mesh.txt", mesh_text_magic}};

void claim_path(const std::string& option, const fs::path& path, PathKind kind) {
  // What is written to FILE.part first and then renamed may not be there either; so with databases.
  const bool written = kind != PathKind::input;
  std::vector<const char*> suffixes{""};
  std::error_code code;
  if (kind == PathKind::file) suffixes.push_back(".part");
  if (kind == PathKind::database) suffixes.insert(suffixes.end(), {".tmp", ".packing", ".solver.log", ".log"});
  if (kind == PathKind::input && !fs::is_directory(path, code) && fs::is_directory(path.string() + ".log", code))
    suffixes.push_back(".log");
  if (keeps_nothing(path)) return;
  for (const char* suffix : suffixes)
    add_claim({option, path.string() + suffix, {}, written, kind != PathKind::model && kind != PathKind::folder});
  if (kind == PathKind::model)
    for (const auto& [name, begin] : model_texts) claim_path(option, path / name, PathKind::file);
}

Error cannot_write(const std::string& option, const fs::path& path, const std::string& why, const std::string& remedy) {
  return input_error("an output cannot be written: " + why, option + " " + path.string(), remedy);
}

/// @param path    what is to be written, in the folder or the folder itself
/// @param folder  which must be there, or which the command makes
void check_folder(const std::string& option, const fs::path& path, const fs::path& folder) {
  std::error_code code;
  fs::path there = folder;
  while (!fs::exists(there, code) && there.has_relative_path()) there = there.parent_path();
  if (!fs::is_directory(there, code))
    throw cannot_write(option, path, there.string() + " is a file, not a folder", "give a place in a folder");
  const auto is_made = [&](const Claim& claim) {
    return claim.written && !claim.encloses && lies_in(folder, claim.path);
  };
  if (there != folder && std::none_of(claims().begin(), claims().end(), is_made))
    throw cannot_write(option, path, "there is no folder " + folder.string(), "make the folder, or give another file");
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    throw cannot_write(option, path, "the folder " + there.string() + " is not writable",
                       "change its permissions, or give another place");
}

void check_file(const std::string& option, const fs::path& file) {
  std::error_code code;
  if (fs::is_directory(file, code))
    throw cannot_write(option, file, "this is a folder", "give the name of a file, in this folder or elsewhere");
  if (fs::exists(file, code) && ::access(file.c_str(), W_OK) != 0)
    throw cannot_write(option, file, "the file may not be changed", "change its permissions, or give another file");
  if (!keeps_nothing(file)) check_folder(option, file, place_of(file).parent_path());
}

/// @return false for --json -, which is no file. @throws Error (input)
bool is_file(const std::string& option, const fs::path& path, PathKind kind) {
  if (path.empty())
    throw input_error("the name of a file is empty", option + " ''",
                      option.starts_with('-') ? "give the name of a file, or omit the option"
                                              : "give the name of a file or a folder");
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
  std::vector<std::tuple<std::string, fs::path, PathKind>> given;
  for (const auto& [option, kind] : declared_options())
    for (const auto& path : option->results())
      if (is_file(option->get_name(), path, kind)) given.emplace_back(option->get_name(), path, kind);
  for (const auto& [option, path, kind] : given) {
    check_length(option, path, kind != PathKind::input);
    claim_path(option, path, kind);
  }
  for (const auto& [option, path, kind] : given) check_place(option, path, kind);
}

void declare_input(const std::string& option, const fs::path& path) { claim_path(option, path, PathKind::input); }
void declare_output(const std::string& option, const fs::path& path, PathKind kind) { claim_path(option, path, kind); }

void check_place(const std::string& option, const fs::path& path, PathKind kind) {
  // DatabaseWriter looks at the folder itself.
  if (kind == PathKind::input || kind == PathKind::database) return;
  if (kind == PathKind::file) return check_file(option, path);
  check_folder(option, path, place_of(path));
  if (kind != PathKind::model) return;
  for (const auto& [name, begin] : model_texts) {
    check_file(option, path / name);
    check_own_text(option, path / name, begin);
  }
}

void check_own_text(const std::string& option, const fs::path& file, std::string_view begin) {
  std::error_code code;
  if (!fs::is_regular_file(file, code)) return;
  std::string text(begin.size(), '\0');
  std::ifstream(file, std::ios::binary).read(text.data(), std::ssize(text));
  if (text != begin)
    throw cannot_write(option, file, "a file that this program has not written has this name",
                       "give another folder, or move the file");
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
  const auto keep = [&](const Error& error) {
    if (last) message("error: {}\n", last->what());
    last = error;
  };
  for (const auto& write : outputs) try {
      write();
    } catch (const Error& error) {
      keep(error);
    } catch (const std::exception& error) {
      keep(failure("an output could not be written", error.what(), "check the free space and the permissions"));
    }
  if (last) throw Error(*last);
}

}  // namespace phynness::cli
