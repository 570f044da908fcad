// The file that takes what libraries say when a call of theirs fails, and which solve asked for it.
#pragma once

#include <filesystem>
#include <string>

namespace phynness {

/// One for the process, as PETSc has one error handler for the process. The file appears with the first entry
/// and is appended to; entries of several ranks do not mix. Failing to write it is no error: the log is told
/// about errors.
class SolverLog {
 public:
  static SolverLog& instance();

  /// @param file  default: phynness-solver-<process id>.log in the folder for temporary files
  void open(std::filesystem::path file, int rank);
  const std::filesystem::path& file() const { return _file; }
  /// What is solved from now on, for the entries.
  void set_context(std::string context) { _context = std::move(context); }
  const std::string& context() const { return _context; }
  void write(const std::string& text) noexcept;
  /// The latest entry.
  const std::string& last() const { return _last; }
  bool is_written() const { return _bytes > 0; }

 private:
  SolverLog();

  std::filesystem::path _file;
  std::string _context, _last;
  int _rank = 0;
  std::size_t _bytes = 0;  ///< written by this process
};

/// PETSc's own error messages go to the log from now on, and nowhere else.
void send_petsc_errors_to_log();

}  // namespace phynness
