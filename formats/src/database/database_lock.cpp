#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/error.hpp>
#include <system_error>

#include "database_log.hpp"
#include "text/durable_file.hpp"

namespace phynness {
namespace {

std::filesystem::path path_of_lock(const std::filesystem::path& file) { return database_log::folder(file) / "lock"; }

/// The process that holds a lock, for messages of other processes.
std::string read_name(const Descriptor& lock, const std::filesystem::path& path) {
  char name[512];
  const auto size = read_at(lock, path, 0, name, sizeof name);
  return size > 0 ? std::string(name, size) : "another process";
}

}  // namespace

struct DatabaseLock::Impl {
  std::filesystem::path path;
  Descriptor file;
  std::string warning;

  Impl(std::filesystem::path where, Descriptor opened, std::string doubt)
      : path(std::move(where)), file(std::move(opened)), warning(std::move(doubt)) {}
  ~Impl() {
    ::unlink(path.c_str());
    ::rmdir(path.parent_path().c_str());  // if it is empty
  }
};

DatabaseLock::DatabaseLock(const std::filesystem::path& file) {
  check_folder_of(file);
  make_log_folder(file);
  const auto path = path_of_lock(file);
  Descriptor lock(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock.is_open())
    throw failure("cannot create the lock " + path.string(), std::generic_category().message(errno),
                  "make the folder of logs writable");
  std::string warning;
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK)
      throw input_error("the database " + file.string() + " is in use", read_name(lock, path),
                        "wait until this process ends, or stop it, and run again with --resume");
    warning = path.string() + " cannot be locked (" + std::generic_category().message(errno) +
              "): make sure that no other process works on this database";
  }
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  const auto name = "process " + std::to_string(::getpid()) + " on " + host;
  // On a full disk the lock is valid but has no name.
  [[maybe_unused]] const bool named =
      ::ftruncate(lock.get(), 0) == 0 && ::pwrite(lock.get(), name.data(), name.size(), 0) > 0;
  _impl = std::make_shared<Impl>(path, std::move(lock), warning);
}

std::string DatabaseLock::holder(const std::filesystem::path& file) {
  const auto path = path_of_lock(file);
  const Descriptor lock(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!lock.is_open() || ::flock(lock.get(), LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK) return "";
  return read_name(lock, path);
}

const std::string& DatabaseLock::warning() const { return _impl->warning; }

}  // namespace phynness
