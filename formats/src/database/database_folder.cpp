#include <unistd.h>

#include <phynness/formats/error.hpp>

#include "database_log.hpp"
#include "database_scan.hpp"

namespace phynness {
namespace fs = std::filesystem;

void check_folder_of(const fs::path& file) {
  const auto folder = fs::absolute(file).parent_path();
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw input_error("the folder for the database does not exist", folder.string(),
                      "make it with: mkdir -p " + folder.string());
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    throw input_error("the folder for the database is not writable", folder.string(),
                      "change its permissions, or write to another folder");
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
  for (const auto& log : database_log::logs_of(file)) fs::remove(log, code);
  fs::remove(database_log::folder(file), code);  // if it is empty: a lock and files of others stay
}

}  // namespace phynness
