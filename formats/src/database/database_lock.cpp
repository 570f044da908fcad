#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/error.hpp>
#include <system_error>

#include "database_log.hpp"

namespace phynness {
namespace {

std::filesystem::path path_of_lock(const std::filesystem::path& file) { return database_log::folder(file) / "lock"; }

/// The process that holds a lock, for messages of other processes.
std::string read_name(const std::filesystem::path& lock) {
  std::string name;
  std::getline(std::ifstream(lock), name);
  return name.empty() ? "another process" : name;
}

Error in_use(const std::filesystem::path& file) {
  return input_error("the database " + file.string() + " is in use", read_name(path_of_lock(file)),
                     "wait until this process ends, or stop it, and run again with --resume");
}

}  // namespace

struct DatabaseLock::Impl {
  std::filesystem::path path;
  int file;
  std::string warning = {};

  ~Impl() {
    ::unlink(path.c_str());
    ::rmdir(path.parent_path().c_str());  // if it is empty
    ::close(file);
  }
};

DatabaseLock::DatabaseLock(const std::filesystem::path& file) {
  check_folder_of(file);
  make_log_folder(file);
  const auto path = path_of_lock(file);
  const int lock = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (lock < 0)
    throw failure("cannot create the lock " + path.string(), std::generic_category().message(errno),
                  "make the folder of logs writable");
  std::string warning;
  if (::flock(lock, LOCK_EX | LOCK_NB) != 0) {
    const int code = errno;
    if (code == EWOULDBLOCK) {
      ::close(lock);
      throw in_use(file);
    }
    warning = path.string() + " cannot be locked (" + std::generic_category().message(code) +
              "): make sure that no other process works on this database";
  }
  _impl = std::shared_ptr<Impl>(new Impl{path, lock, warning});
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  std::ofstream(path) << "process " << ::getpid() << " on " << host;  // on a full disk the lock is valid without it
}

void DatabaseLock::require_free(const std::filesystem::path& file) {
  const int lock = ::open(path_of_lock(file).c_str(), O_RDONLY | O_CLOEXEC);
  if (lock < 0) return;
  const bool held = ::flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(lock);
  if (held) throw in_use(file);
}

const std::string& DatabaseLock::warning() const { return _impl->warning; }

}  // namespace phynness
