// Files that survive a killed process, a full disk or a power failure: checked writes, fsync, rename.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>

namespace phynness {

/// A file to which complete records are appended.
class AppendFile {
 public:
  /// @throws Error (failure) if the file exists or cannot be created
  explicit AppendFile(const std::filesystem::path& path);
  /// Writes all bytes; on return the operating system has them.
  /// @throws Error (failure) after a failed write, such as on a full disk; the file then has its previous size
  void append(const void* bytes, std::size_t size);
  /// Forces the file to the disk and closes it. @throws Error (failure)
  void close();

 private:
  std::filesystem::path _path;
  std::ofstream _out;
  std::uintmax_t _end = 0;
  std::chrono::steady_clock::time_point _synced = std::chrono::steady_clock::now();
};

/// Reserves room on the disk for bytes that follow `offset` of a file, whose size stays; it is created. Where the file
/// system cannot do that, the free space is compared.
/// @throws Error (failure) if there is not enough of it, or if a limit of the size of files is exceeded
void reserve_room(const std::filesystem::path& path, std::uint64_t offset, std::uint64_t bytes);

/// Forces `from` to the disk, renames it to `to` atomically, and forces the rename to the disk. @throws Error (failure)
void replace_durably(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace phynness
