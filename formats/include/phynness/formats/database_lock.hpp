// One process at a time works on a database.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

namespace phynness {

/// Held as long as the object lives, on FILE.log/lock; the operating system releases it when the process dies,
/// however that happens. For the process that creates and packs; readers and appenders need none.
class DatabaseLock {
 public:
  /// Makes FILE.log/ if it is not there.
  /// @throws Error (input) if another process holds it, naming that process; or if the folder cannot be written
  explicit DatabaseLock(const std::filesystem::path& file);
  /// Removes the lock file, and FILE.log/ if nothing else is in it.
  ~DatabaseLock();
  DatabaseLock(DatabaseLock&&) noexcept;
  DatabaseLock& operator=(DatabaseLock&&) noexcept;

  /// Which process holds the lock of `file`; empty if none does, or locks do not work here.
  static std::string holder(const std::filesystem::path& file);

  /// Empty, or why there is no protection here: some network file systems have no locks.
  const std::string& warning() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness
