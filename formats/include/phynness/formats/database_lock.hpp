// A lock by which only one process at a time works on a database.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace phynness {

/// A lock on FILE.log/lock during the lifetime of the object and its copies, the last of which removes the lock file,
/// and FILE.log/ if it is empty then. The operating system releases it when the process ends in any way. It is needed
/// by the process that creates and packs a database, but not by readers and by ranks that append.
class DatabaseLock {
 public:
  /// Creates FILE.log/ if it does not exist.
  /// @throws Error (input) if another process, which the message names, holds the lock, or if the folder is not
  /// writable
  explicit DatabaseLock(const std::filesystem::path& file);

  /// Throws the same error without a lock of its own. On file systems without locks there is none.
  static void require_free(const std::filesystem::path& file);

  /// Empty, or the reason why the lock gives no protection, as on network file systems without locks.
  const std::string& warning() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> _impl;
};

}  // namespace phynness
