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

void sync_path(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail("cannot open", path, errno);
  const int code = ::fsync(file) == 0 ? 0 : errno;
  ::close(file);
  // Some network file systems cannot sync a folder; the rename is then only as durable as the file system makes it.
  if (code != 0 && code != EINVAL && code != ENOTSUP) fail("cannot sync", path, code);
}

}  // namespace

AppendFile::AppendFile(const std::filesystem::path& path) : _path(path) {
  // C++20's streams cannot be told to create a file only.
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file < 0) fail("cannot create", path, errno);
  ::close(file);
  _out.open(path, std::ios::binary);
  if (!_out) fail("cannot open", path, errno);
}

void AppendFile::append(const void* bytes, std::size_t size) {
  _out.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size)).flush();
  if (!_out) {
    const int code = errno;
    _out.close();
    std::error_code none;
    std::filesystem::resize_file(_path, _end, none);  // without the torn record
    fail("cannot write", _path, code);
  }
  _end += size;
  // A sync takes milliseconds; with this interval a power failure loses at most seconds of work.
  constexpr std::chrono::seconds between_syncs{10};
  if (const auto now = std::chrono::steady_clock::now(); now - _synced > between_syncs) {
    sync_path(_path);
    _synced = now;
  }
}

void AppendFile::close() {
  if (!_out.is_open()) return;
  _out.close();
  if (!_out) fail("cannot close", _path, errno);
  sync_path(_path);
}

void reserve_room(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t bytes) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && offset + bytes > limit.rlim_cur) fail("cannot write", path, EFBIG);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0) fail("cannot create", path, errno);
  const auto first = static_cast<off_t>(offset), size = static_cast<off_t>(bytes);
  int code = ::fallocate(file, FALLOC_FL_KEEP_SIZE, first, size) == 0 ? 0 : errno;
  ::close(file);
  if (code == EOPNOTSUPP || code == ENOSYS) code = std::filesystem::space(path).available < bytes ? ENOSPC : 0;
  if (code != 0) fail("cannot write", path, code);
}

void replace_durably(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::filesystem::resize_file(from, std::filesystem::file_size(from));  // gives back room that was reserved
  sync_path(from);
  if (::rename(from.c_str(), to.c_str()) != 0) fail("cannot rename to", to, errno);
  sync_path(std::filesystem::absolute(to).parent_path());
}

}  // namespace phynness
