#include "output_places.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <fstream>
#include <optional>
#include <phynness/formats/error.hpp>
#include <system_error>

#include "streams.hpp"

namespace phynness::cli {
namespace {

namespace fs = std::filesystem;

Error cannot_write(const std::string& option, const fs::path& path, const std::string& why, const std::string& remedy) {
  return input_error("an output cannot be written: " + why, option + " " + path.string(), remedy);
}

bool lies_in_any(const fs::path& folder, const std::vector<fs::path>& made) {
  std::error_code code;
  for (auto at = folder; at.has_relative_path(); at = at.parent_path())
    for (const auto& other : made)
      if (at == fs::weakly_canonical(fs::absolute(other), code)) return true;
  return false;
}

/// The pipe stays open to the end of the process: a reader would take the first end of a writer for the end of the
/// data.
void check_pipe(const std::string& option, const fs::path& pipe) {
  if (::open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC) >= 0) return;
  throw cannot_write(option, pipe, errno == ENXIO ? "nothing reads this pipe" : std::generic_category().message(errno),
                     "start what reads it first, or give a file");
}

/// @param path  what is to be written, in the folder or the folder itself
void check_folder(const std::string& option, const fs::path& path, const fs::path& folder) {
  std::error_code code;
  const auto there = existing_part(fs::absolute(folder, code));
  if (!fs::is_directory(there, code))
    throw cannot_write(option, path, there.string() + " is a file, not a folder", "give a place in a folder");
  if (::access(there.c_str(), W_OK | X_OK) != 0)
    throw cannot_write(option, path, "the folder " + there.string() + " is not writable",
                       "change its permissions, or give another place");
}

}  // namespace

bool is_stdout(const fs::path& path) { return path == "-"; }

fs::path existing_part(fs::path path) {
  std::error_code code;
  while (!fs::exists(path, code) && path.has_relative_path()) path = path.parent_path();
  return path;
}

void check_folder_place(const std::string& option, const fs::path& folder) { check_folder(option, folder, folder); }

void check_file_place(const std::string& option, const fs::path& file, const std::vector<fs::path>& made) {
  std::error_code code;
  const auto target = fs::is_symlink(file, code) ? fs::weakly_canonical(file, code) : file;
  const auto status = fs::status(target, code);
  if (fs::is_directory(status))
    throw cannot_write(option, file, "this is a folder", "give the name of a file, in this folder or elsewhere");
  if (fs::is_fifo(status)) return check_pipe(option, file);
  if (fs::exists(status) && ::access(target.c_str(), W_OK) != 0)
    throw cannot_write(option, file, "the file may not be changed", "change its permissions, or give another file");
  if (fs::exists(status) && !fs::is_regular_file(status)) return;  // a device, which is written in place
  const auto folder = fs::absolute(target, code).parent_path();
  if (!fs::exists(folder, code) && lies_in_any(fs::weakly_canonical(folder, code), made)) return;
  const auto there = existing_part(folder);
  if (there != folder && fs::is_directory(there, code))
    throw cannot_write(option, file, "there is no folder " + folder.string(), "make the folder, or give another file");
  check_folder(option, file, folder);
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
