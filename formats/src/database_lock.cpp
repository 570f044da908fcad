#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/error.hpp>
#include <system_error>

#include "database_log.hpp"
#include "durable_file.hpp"

namespace phynness {
namespace {

constexpr char own_words[] = "process ";

/// Name of this process, for messages of other processes. A lock begins with it.
std::string own_name() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  return own_words + std::to_string(::getpid()) + " on " + host;
}

std::string read_name(const Descriptor& lock, const std::filesystem::path& path) {
  char name[512];
  const auto size = read_at(lock, path, 0, name, sizeof name);
  return size > 0 ? std::string(name, size) : "another process";
}

/// False if the file has been removed or replaced since it was opened.
bool is_still(const Descriptor& lock, const std::filesystem::path& path) {
  struct stat opened {
  }, named{};
  return ::fstat(lock.get(), &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino;
}

Descriptor open_lock(const std::filesystem::path& path, int flags) {
  return Descriptor(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644));
}

}  // namespace

struct DatabaseLock::Impl {
  std::filesystem::path path;
  Descriptor file;
  std::string warning;

  ~Impl() {
    // Packing removes the folder, after which another process may have made a lock of its own.
    if (!is_still(file, path)) return;
    ::unlink(path.c_str());
    ::rmdir(path.parent_path().c_str());
  }
};

DatabaseLock::DatabaseLock(const std::filesystem::path& file) : _impl(std::make_shared<Impl>()) {
  check_folder_of(file);
  make_log_folder(file);
  const auto path = database_log::folder(file) / "lock";
  Descriptor lock = open_lock(path, O_RDWR | O_CREAT);
  constexpr const char* remedy = "move what lies in the place of the lock to another folder";
  if (!lock.is_open()) {
    const auto reason = std::generic_category().message(errno);
    if (errno == ELOOP || errno == EISDIR) throw input_error("no lock can be made: " + path.string(), reason, remedy);
    throw failure("cannot create the lock " + path.string(), reason, "make the folder of logs writable");
  }
  int code = 0;
  while (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 && (code = errno) == EINTR) code = 0;
  if (code == EWOULDBLOCK)
    throw input_error("the database " + file.string() + " is in use", read_name(lock, path),
                      "wait until this process ends, or stop it, and run again with --resume");
  char begin[sizeof own_words - 1];
  const auto size = read_at(lock, path, 0, begin, sizeof begin);
  if (!std::string_view(own_words).starts_with(std::string_view(begin, size)))
    throw input_error("no lock can be made: " + path.string(), "the file is not one of this program", remedy);
  _impl->path = path;
  _impl->file = std::move(lock);
  if (code != 0)
    _impl->warning = path.string() + " cannot be locked (" + std::generic_category().message(code) +
                     "): make sure that no other process works on this database";
  // On a full disk the lock is valid but has no name.
  const auto name = own_name();
  [[maybe_unused]] const bool named =
      ::ftruncate(_impl->file.get(), 0) == 0 &&
      ::pwrite(_impl->file.get(), name.data(), name.size(), 0) == static_cast<ssize_t>(name.size());
}

std::string DatabaseLock::holder(const std::filesystem::path& file) {
  const auto path = database_log::folder(file) / "lock";
  const Descriptor lock = open_lock(path, O_RDONLY);
  if (!lock.is_open() || ::flock(lock.get(), LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK) return "";
  return read_name(lock, path);
}

const std::string& DatabaseLock::warning() const { return _impl->warning; }

}  // namespace phynness
