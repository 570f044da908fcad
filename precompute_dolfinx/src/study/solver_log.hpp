// The log file with messages of failed library calls and the solves in which they occurred.
#pragma once

#include <filesystem>
#include <string>

namespace phynness {

/// The log of this process, because PETSc has one error handler per process. The file is created with the first entry.
/// Entries are appended, and entries of several ranks do not mix. A failed write is ignored, because entries are
/// written during error handling.
class SolverLog {
 public:
  static SolverLog& instance();

  /// @param file  default without this call: phynness-solver-<process id>.log in the folder of temporary files
  void open(std::filesystem::path file, int rank);
  const std::filesystem::path& file() const { return _file; }
  /// Sets the description of the present solve in later entries.
  void set_context(std::string context) { _context = std::move(context); }
  const std::string& context() const { return _context; }
  void write(const std::string& text) noexcept;
  /// The latest entry.
  const std::string& last() const { return _last; }

 private:
  SolverLog();

  std::filesystem::path _file;
  std::string _context, _last;
  int _rank = 0;
  std::size_t _bytes = 0;  ///< bytes written by this process
};

/// Redirects PETSc's error messages to the log.
void send_petsc_errors_to_log();

}  // namespace phynness
