// Files that survive a killed process, a full disk or a power failure: checked writes, fsync, rename.
#pragma once

#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <utility>

namespace phynness {

/// A file descriptor that its destructor closes.
class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : _fd(fd) {}
  ~Descriptor();
  Descriptor(Descriptor&& other) noexcept : _fd(other.release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(_fd, other._fd);
    return *this;
  }
  int get() const { return _fd; }
  bool is_open() const { return _fd >= 0; }
  int release() { return std::exchange(_fd, -1); }

 private:
  int _fd = -1;
};

/// A file to which complete records are appended.
class AppendFile {
 public:
  AppendFile() = default;
  /// @throws Error (failure) if the file exists or cannot be created
  static AppendFile create(const std::filesystem::path& path);
  /// Writes all bytes. On return the operating system has them; the disk has them within seconds after the next append.
  /// @throws Error (failure) after a failed write, such as on a full disk; the file then has its previous size
  void append(const void* bytes, std::size_t size);
  /// Forces the file to the disk and closes it. @throws Error (failure)
  void close();
  bool is_open() const { return _descriptor.is_open(); }

 private:
  Descriptor _descriptor;
  std::filesystem::path _path;
  std::int64_t _end = 0;
  std::chrono::steady_clock::time_point _synced = std::chrono::steady_clock::now();
};

/// A number from the bytes of a file.
template <class T>
T value_at(const unsigned char* bytes) {
  static_assert(std::endian::native == std::endian::little,
                "databases and logs are little-endian; byte swaps for this host are not implemented");
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Reads `size` bytes at `offset`, or fewer at the end of the file. @throws Error (failure)
std::size_t read_at(const Descriptor& file, const std::filesystem::path& path, std::int64_t offset, void* bytes,
                    std::size_t size);
Descriptor open_for_reading(const std::filesystem::path& path);

/// Reserves room on the disk for bytes that follow `offset` of an existing file, whose size stays. Where the file
/// system cannot do that, the free space is compared.
/// @throws Error (failure) if there is not enough of it, or if a limit of the size of files is exceeded
void reserve_room(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t bytes);

/// Forces `from` to the disk, renames it to `to` atomically, and forces the rename to the disk. @throws Error (failure)
void replace_durably(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace phynness
