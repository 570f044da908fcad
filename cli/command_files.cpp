#include "command_files.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <climits>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mesh.hpp>
#include <phynness/formats/printable.hpp>
#include <phynness/schema/text_reader.hpp>
#include <string_view>
#include <variant>
#include <vector>

#include "output_places.hpp"
#include "streams.hpp"

namespace phynness::cli {
namespace {

namespace fs = std::filesystem;

/// A file or directory that the command reads or writes.
struct Claim {
  std::string option;
  fs::path path;      ///< as given by the user
  fs::path resolved;  ///< canonical
  bool written = false;
  bool encloses = true;  ///< no other claim may lie inside; also true for files
};

/// Canonical path. Symbolic links are followed even if their targets do not exist yet.
fs::path resolve(const fs::path& path) {
  constexpr int most_links = 40;
  std::error_code code;
  fs::path found = fs::absolute(path, code);
  for (int links = 0; links < most_links; ++links) {
    const auto canonical = fs::weakly_canonical(found, code);
    found = code ? found.lexically_normal() : canonical;
    if (!found.has_filename()) found = found.parent_path();  // trailing slash
    fs::path at, rest;
    bool is_link = false;
    for (const auto& part : found) {
      if (is_link) {
        rest /= part;
      } else {
        at /= part;
        is_link = fs::is_symlink(fs::symlink_status(at, code));
      }
    }
    if (!is_link) break;
    const auto target = fs::read_symlink(at, code);
    if (code) break;
    found = at.parent_path() / target / rest;
  }
  return found;
}

bool same(const fs::path& a, const fs::path& b) {
  std::error_code code;
  return a == b || fs::equivalent(a, b, code);
}

bool lies_in(const fs::path& inner, const fs::path& outer) {
  for (auto at = inner; at.has_relative_path();) {
    at = at.parent_path();
    if (same(at, outer)) return true;
  }
  return false;
}

/// Pipes, terminals and /dev/null keep no data that could be overwritten.
bool keeps_nothing(const fs::path& path) {
  std::error_code code;
  const auto type = fs::status(path, code).type();
  return type != fs::file_type::regular && type != fs::file_type::directory && type != fs::file_type::not_found &&
         type != fs::file_type::none;
}

/// Names both limits, so that the remedy needs to be followed once.
/// @throws Error (input) if the file system cannot hold a name or the path, or, of an output, what is made of them
void check_length(const std::string& option, const fs::path& path, bool written) {
  // Longer than .shard-2147483646-of-2147483647.log/rank-0000-0000 and than all that is made in a folder.
  const std::size_t added = written ? 64 : 0;
  std::error_code code;
  const auto absolute = fs::absolute(path, code);
  const long of_folder = ::pathconf(existing_part(absolute).c_str(), _PC_NAME_MAX);
  const std::size_t longest_name = of_folder > 0 ? static_cast<std::size_t>(of_folder) : NAME_MAX;
  const std::size_t most = longest_name - added;
  std::size_t bytes = (absolute.has_filename() ? absolute : absolute.parent_path()).filename().native().size();
  for (const auto& part : absolute)
    if (part.native().size() > longest_name) bytes = part.native().size();
  const bool name_fits = bytes <= most;
  if (name_fits) bytes = absolute.native().size();
  if (name_fits && bytes + added < PATH_MAX) return;
  throw input_error(
      fmt::format("the {} of a file is too long", name_fits ? "path" : "name"),
      fmt::format("{} {}: {} bytes", option, shortened(path.string(), 60), bytes),
      fmt::format("give a name of at most {} bytes, in a path of at most {}", most, PATH_MAX - 1 - added));
}

class Claims {
 public:
  void add(Claim claim) {
    if (claim.path.empty() || keeps_nothing(claim.path)) return;
    claim.resolved = resolve(claim.path);
    for (const auto& other : _claims) check(claim, other);
    _claims.push_back(std::move(claim));
  }
  /// Adds a directory together with its entries, so that a second name of an entry is found by its inode.
  void add_tree(const Claim& claim) {
    add(claim);
    std::error_code code;
    for (fs::directory_iterator entry(claim.path, code), end; !code && entry != end; entry.increment(code)) {
      auto inside = claim;
      inside.path = entry->path();
      add(inside);
    }
  }

 private:
  static void check(const Claim& a, const Claim& b) {
    if (!(a.written || b.written) || a.option == b.option) return;
    const auto takes = [](const Claim& whole, const Claim& part) {
      return whole.encloses && (same(part.resolved, whole.resolved) || lies_in(part.resolved, whole.resolved));
    };
    if (!takes(a, b) && !takes(b, a)) return;
    const auto& output = a.written ? a : b;
    const auto& other = a.written ? b : a;
    throw input_error(
        fmt::format("an output would overwrite {}", other.written ? "another output" : "an input"),
        fmt::format("{} {} and {} {}", output.option, output.path.string(), other.option, other.path.string()),
        fmt::format("give {} another file or directory", output.option));
  }

  std::vector<Claim> _claims;
};

/// All claims of the command that this process runs.
Claims& claims() {
  static Claims all;
  return all;
}

using Kind = std::variant<InputKind, OutputKind>;
std::map<const CLI::Option*, Kind>& declared_options() {
  static std::map<const CLI::Option*, Kind> all;
  return all;
}

fs::path with_suffix(const fs::path& path, const char* suffix) { return path.string() + suffix; }

void claim_input(const std::string& option, const fs::path& path, InputKind kind) {
  check_length(option, path, false);
  Claim claim{option, path, {}, false, kind == InputKind::whole};
  std::error_code code;
  if (kind == InputKind::folder) return claims().add(claim);
  claims().add_tree(claim);
  claim.path = with_suffix(path, ".log");
  if (!fs::is_directory(path, code) && fs::is_directory(claim.path, code)) claims().add_tree(claim);
}

void claim_output(const std::string& option, const fs::path& path, OutputKind kind) {
  const bool encloses = kind != OutputKind::model && kind != OutputKind::folder;
  const auto claim = [&](const fs::path& of) { return Claim{option, of, {}, true, encloses}; };
  // Text files are first written to FILE.part and then renamed, so that FILE.part is also an output.
  const auto claim_text = [&](const fs::path& file) {
    claims().add({option, file, {}, true, true});
    claims().add({option, with_suffix(file, ".part"), {}, true, true});
  };
  if (keeps_nothing(path)) return;
  switch (kind) {
    case OutputKind::file:
      return claim_text(path);
    case OutputKind::database:
      for (const char* suffix : {"", ".tmp", ".packing", ".solver.log"}) claims().add(claim(with_suffix(path, suffix)));
      return claims().add_tree(claim(with_suffix(path, ".log")));
    case OutputKind::model:
      claims().add(claim(path));
      for (const char* name : {"model.txt", "mesh.txt"}) claim_text(path / name);
      return;
    case OutputKind::folder:
      return claims().add(claim(path));
    case OutputKind::tree:
      return claims().add_tree(claim(path));
  }
}

}  // namespace

void declare(CLI::Option& option, InputKind kind) {
  option.type_name("INPUT");
  declared_options()[&option] = kind;
}
void declare(CLI::Option& option, OutputKind kind) {
  option.type_name("OUTPUT");
  declared_options()[&option] = kind;
}

namespace {

/// A path that the command line gives to a declared option.
struct Given {
  std::string option;
  fs::path path;
  Kind kind;
};

void collect(const CLI::App& app, std::vector<Given>& all) {
  for (const auto* option : app.get_options()) {
    const auto declared = declared_options().find(option);
    if (declared == declared_options().end()) continue;
    for (const auto& path : option->results()) all.push_back({option->get_name(), path, declared->second});
  }
  for (const auto* command : app.get_subcommands()) collect(*command, all);
}

/// @return false for --json -, which is no file. @throws Error (input)
bool is_file(const Given& given) {
  if (given.path.empty())
    throw input_error("the name of a file is empty", given.option + " ''",
                      given.option.starts_with('-') ? "give the name of a file, or omit the option"
                                                    : "give the name of a file or a folder");
  if (!std::holds_alternative<OutputKind>(given.kind) || !is_stdout(given.path)) return true;
  if (given.option != "--json")
    throw input_error("only --json can be written to stdout", given.option + " -",
                      "give ./- for a file of this name, or another name");
  print_results_on_stderr();
  return false;
}

void check_place(const Given& given, const std::vector<fs::path>& made) {
  const auto* output = std::get_if<OutputKind>(&given.kind);
  if (!output) return;
  switch (*output) {
    case OutputKind::file:
      return check_file_place(given.option, given.path, made);
    case OutputKind::database:
      return;  // DatabaseWriter and merge_shards() look at the folder first
    case OutputKind::model:
      for (const auto& [name, begin] :
           {std::pair{"model.txt", std::string_view(schema::model_magic)}, std::pair{"mesh.txt", mesh_text_magic}}) {
        check_file_place(given.option, given.path / name, made);
        check_own_text(given.option, given.path / name, begin);
      }
      [[fallthrough]];
    case OutputKind::folder:
    case OutputKind::tree:
      return check_folder_place(given.option, given.path);
  }
}

}  // namespace

void check_files(const CLI::App& app) {
  std::vector<Given> all;
  collect(app, all);
  all.erase(std::remove_if(all.begin(), all.end(), [](const Given& given) { return !is_file(given); }), all.end());
  std::vector<fs::path> made;
  for (const auto& given : all)
    if (const auto* input = std::get_if<InputKind>(&given.kind)) {
      claim_input(given.option, given.path, *input);
    } else {
      const auto kind = std::get<OutputKind>(given.kind);
      check_length(given.option, given.path, true);
      claim_output(given.option, given.path, kind);
      if (kind != OutputKind::file && kind != OutputKind::database) made.push_back(given.path);
    }
  for (const auto& given : all) check_place(given, made);
}

void declare_input(const std::string& option, const std::filesystem::path& path) {
  claim_input(option, path, InputKind::whole);
}
void declare_output(const std::string& option, const std::filesystem::path& path, OutputKind kind) {
  claim_output(option, path, kind);
}

}  // namespace phynness::cli
