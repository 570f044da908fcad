#include <unistd.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <phynness/formats/error.hpp>

#include "database_log.hpp"
#include "database_scan.hpp"

namespace phynness {
namespace fs = std::filesystem;
namespace {

/// @throws Error (input) if `folder` holds the logs of a database, or is where they would be
void refuse_folder_of_logs(const fs::path& folder, const fs::path& file) {
  std::error_code code;
  const auto resolved = fs::weakly_canonical(folder, code);
  if (resolved.extension() != ".log") return;
  const auto database = resolved.parent_path() / resolved.stem();
  if (database_log::logs_of(database).empty() && !fs::exists(resolved / "lock", code) &&
      !fs::is_regular_file(database, code))
    return;
  throw input_error("the database is to be written into the folder of logs of another one", file.string(),
                    "choose another folder: " + resolved.string() + " belongs to " + database.string());
}

/// False for a file of somebody else that has the name of a log.
bool begins_as_log(const fs::path& file) {
  std::array<char, database_log::log_magic.size()> found{};
  std::ifstream in(file, std::ios::binary);
  in.read(found.data(), found.size());
  return std::equal(found.begin(), found.begin() + in.gcount(), database_log::log_magic.begin());
}

}  // namespace

void check_folder_of(const fs::path& file) {
  const auto folder = fs::absolute(file).parent_path();
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw input_error("the folder for the database does not exist", folder.string(),
                      "make it with: mkdir -p " + folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw input_error("the folder for the database is not writable", folder.string(),
                      "change its permissions, or write to another folder");
  refuse_folder_of_logs(folder, file);
}

void make_log_folder(const fs::path& file) {
  std::error_code code;
  fs::create_directories(database_log::folder(file), code);
  if (code)
    throw failure("cannot create the folder of logs " + database_log::folder(file).string(), code.message(),
                  "check permissions and free space");
}

void remove_logs(const fs::path& file) {
  std::error_code code;
  for (const auto& log : database_log::logs_of(file))
    if (begins_as_log(log)) fs::remove(log, code);
  const auto folder = database_log::folder(file);
  const auto lock = folder / "lock";
  // A holder's lock goes with its folder; where the folder has to stay, the holder takes its lock away itself.
  std::vector<fs::path> others;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code))
    if (entry->path() != lock) others.push_back(entry->path());
  if (!others.empty()) return;
  fs::remove(lock, code);
  fs::remove(folder, code);
}

}  // namespace phynness
