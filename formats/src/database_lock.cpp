#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <phynness/formats/database_lock.hpp>
#include <phynness/formats/error.hpp>
#include <system_error>

#include "database_folder.hpp"
#include "database_log.hpp"
#include "durable_file.hpp"

namespace phynness {
namespace {

constexpr const char* name_prefix = "process ";

/// Name of this process, for messages of other processes.
std::string own_name() {
  char host[256] = "";
  ::gethostname(host, sizeof host - 1);
  return name_prefix + std::to_string(::getpid()) + " on " + host;
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
  return ::fstat(lock.get(), &opened) == 0 && ::stat(path.c_str(), &named) == 0 && opened.st_ino == named.st_ino &&
         opened.st_dev == named.st_dev;
}

/// @throws Error (input) unless the file at `path` is a lock: a regular file, empty or with the name of a holder
void refuse_foreign(const Descriptor& lock, const std::filesystem::path& path) {
  struct stat opened {};
  const bool regular = ::fstat(lock.get(), &opened) == 0 && S_ISREG(opened.st_mode);
  if (regular && (opened.st_size == 0 || read_name(lock, path).starts_with(name_prefix))) return;
  throw input_error("what lies in the place of a database's lock is no lock", path.string(),
                    "move it elsewhere, and write nothing into folders of logs");
}

/// A symbolic link is not followed, and a pipe without a writer does not block.
Descriptor open_lock(const std::filesystem::path& path, int flags) {
  return Descriptor(::open(path.c_str(), flags | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0644));
}

}  // namespace

struct DatabaseLock::Impl {
  std::filesystem::path path;
  Descriptor file;
  std::string warning;

  ~Impl() {
    // The file is removed while the lock is held. A process that has opened it before detects this and opens the next
    // one.
    if (!is_still(file, path)) return;
    ::unlink(path.c_str());
    ::rmdir(path.parent_path().c_str());
  }
};

DatabaseLock::DatabaseLock(const std::filesystem::path& file) {
  check_folder_of(file);
  const auto path = database_log::folder(file) / "lock";
  constexpr int most_attempts = 1000;
  for (int attempt = 1;; ++attempt) {
    make_log_folder(file);
    Descriptor lock = open_lock(path, O_RDWR | O_CREAT);
    if (!lock.is_open()) {
      if (errno == ENOENT && attempt < most_attempts) continue;  // the last holder has removed the folder
      if (errno == ELOOP)
        throw input_error("what lies in the place of a database's lock is no lock", path.string() + " is a link",
                          "remove the link");
      throw failure("cannot create the lock " + path.string(), std::generic_category().message(errno),
                    "make the folder of logs writable");
    }
    refuse_foreign(lock, path);
    int code = 0;
    while (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 && (code = errno) == EINTR) code = 0;
    if (code == EWOULDBLOCK)
      throw input_error("the database " + file.string() + " is in use", read_name(lock, path),
                        "wait until this process ends, or stop it, and run again with --resume");
    if (code == 0 && !is_still(lock, path)) {
      if (attempt < most_attempts) continue;
      throw failure("cannot take the lock " + path.string(), "it is removed again and again",
                    "see to it that no other process works on this database");
    }
    _impl = std::make_unique<Impl>();
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
    return;
  }
}

DatabaseLock::~DatabaseLock() = default;
DatabaseLock::DatabaseLock(DatabaseLock&&) noexcept = default;
DatabaseLock& DatabaseLock::operator=(DatabaseLock&&) noexcept = default;

std::string DatabaseLock::holder(const std::filesystem::path& file) {
  const auto path = database_log::folder(file) / "lock";
  const Descriptor lock = open_lock(path, O_RDONLY);
  if (!lock.is_open() || ::flock(lock.get(), LOCK_SH | LOCK_NB) == 0 || errno != EWOULDBLOCK) return "";
  return read_name(lock, path);
}

const std::string& DatabaseLock::warning() const { return _impl->warning; }

}  // namespace phynness
