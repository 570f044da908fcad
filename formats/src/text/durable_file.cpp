#include "durable_file.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <phynness/formats/error.hpp>
#include <system_error>

namespace phynness {
namespace {

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, int code) {
  const char* remedy = code == ENOSPC || code == EDQUOT || code == EFBIG
                           ? "free space or raise the limit, then run again with --resume: complete records are kept"
                       : code == EACCES || code == EPERM || code == EROFS
                           ? "make the folder writable, or choose another folder"
                           : "check the disk, then run again with --resume: complete records are kept";
  throw failure(std::string(what) + " " + path.string(), std::generic_category().message(code), remedy);
}

Descriptor opened(const std::filesystem::path& path, int flags) {
  Descriptor file(::open(path.c_str(), flags | O_CLOEXEC));
  if (!file.is_open()) fail("cannot open", path, errno);
  return file;
}

void sync_path(const std::filesystem::path& path, int flags) {
  const auto file = opened(path, flags);
  // Some network file systems cannot sync a folder; the rename is then only as durable as the file system makes it.
  if (::fsync(file.get()) != 0 && errno != EINVAL && errno != ENOTSUP) fail("cannot sync", path, errno);
}

/// @return errno, or 0
int write_all(const Descriptor& file, std::int64_t offset, const void* bytes, std::size_t size) {
  const auto* from = static_cast<const char*>(bytes);
  for (std::size_t done = 0; done < size;) {
    const auto written = ::pwrite(file.get(), from + done, size - done, offset + static_cast<std::int64_t>(done));
    if (written > 0)
      done += static_cast<std::size_t>(written);
    else if (written == 0 || errno != EINTR)
      return written < 0 ? errno : ENOSPC;
  }
  return 0;
}

}  // namespace

Descriptor::~Descriptor() {
  if (_fd >= 0) ::close(_fd);
}

AppendFile AppendFile::create(const std::filesystem::path& path) {
  AppendFile file;
  file._path = path;
  file._descriptor = Descriptor(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file.is_open()) fail("cannot create", path, errno);
  return file;
}

void AppendFile::append(const void* bytes, std::size_t size) {
  if (const int code = write_all(_descriptor, _end, bytes, size)) {
    // Without truncation a torn record would precede records that are appended later.
    if (::ftruncate(_descriptor.get(), _end) != 0)
      fail("cannot write, and cannot truncate to the last complete record,", _path, code);
    fail("cannot write", _path, code);
  }
  _end += static_cast<std::int64_t>(size);
  // A sync takes milliseconds; with this interval a power failure loses at most seconds of work.
  constexpr std::chrono::seconds between_syncs{10};
  if (const auto now = std::chrono::steady_clock::now(); now - _synced > between_syncs) {
    if (::fdatasync(_descriptor.get()) != 0 && errno != EINVAL) fail("cannot sync", _path, errno);
    _synced = now;
  }
}

void AppendFile::close() {
  if (!is_open()) return;
  if (::fsync(_descriptor.get()) != 0 && errno != EINVAL) fail("cannot sync", _path, errno);
  if (::close(_descriptor.release()) != 0 && errno != EINTR) fail("cannot close", _path, errno);
}

Descriptor open_for_reading(const std::filesystem::path& path) { return opened(path, O_RDONLY); }

void reserve_room(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && offset + bytes > limit.rlim_cur) fail("cannot write", path, EFBIG);
  const auto file = opened(path, O_WRONLY);
  if (::fallocate(file.get(), FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset), static_cast<off_t>(bytes)) == 0) return;
  int code = errno;
  if (code == EOPNOTSUPP || code == ENOSYS) code = std::filesystem::space(path).available < bytes ? ENOSPC : 0;
  if (code != 0) fail("cannot write", path, code);
}

std::size_t read_at(const Descriptor& file, const std::filesystem::path& path, std::int64_t offset, void* bytes,
                    std::size_t size) {
  auto* to = static_cast<char*>(bytes);
  std::size_t done = 0;
  while (done < size) {
    const auto got = ::pread(file.get(), to + done, size - done, offset + static_cast<std::int64_t>(done));
    if (got == 0) break;
    if (got > 0)
      done += static_cast<std::size_t>(got);
    else if (errno != EINTR)
      throw failure("cannot read " + path.string(), std::generic_category().message(errno), "check the disk");
  }
  return done;
}

void replace_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::filesystem::resize_file(from, std::filesystem::file_size(from));  // gives back room that was reserved
  sync_path(from, O_RDONLY);
  if (::rename(from.c_str(), to.c_str()) != 0) fail("cannot rename to", to, errno);
  sync_path(std::filesystem::absolute(to).parent_path(), O_RDONLY | O_DIRECTORY);
}

}  // namespace phynness
