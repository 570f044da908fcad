#include "solver_log.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <system_error>

#include "solve/petsc_check.hpp"

namespace phynness {
namespace {

constexpr std::size_t most_bytes = 1 << 20;

/// PETSc calls this for each function of the call stack through which an error passes; the first call has the message.
PetscErrorCode on_petsc_error(MPI_Comm, int line, const char* function, const char* file, PetscErrorCode code,
                              PetscErrorType type, const char* message, void*) try {
  std::string text;
  if (type == PETSC_ERROR_INITIAL) {
    const char* general = nullptr;
    PetscErrorMessage(code, &general, nullptr);
    text = std::string("PETSc: ") + (general ? general : "error") +
           (message && *message ? std::string(": ") + message : "") + "\n";
  }
  text += std::string("  in ") + (function ? function : "?") + ", " + (file ? file : "?") + ":" + std::to_string(line);
  SolverLog::instance().write(text);
  return code;
} catch (...) {  // out of memory
  return code;
}

}  // namespace

SolverLog::SolverLog() {
  std::error_code ignored;
  _file = std::filesystem::temp_directory_path(ignored) / ("phynness-solver-" + std::to_string(::getpid()) + ".log");
}

SolverLog& SolverLog::instance() {
  static SolverLog log;
  return log;
}

void SolverLog::open(std::filesystem::path file, int rank) {
  _file = std::move(file);
  _rank = rank;
}

void SolverLog::write(const std::string& text) noexcept try {
  _last = text;
  if (_bytes >= most_bytes) return;
  std::string entry = "rank " + std::to_string(_rank);
  if (!_context.empty()) entry += ", " + _context;
  entry += ": " + text + "\n";
  const bool full = _bytes + entry.size() > most_bytes;
  if (full) entry = "the log is full: later entries are omitted\n";
  // O_NOFOLLOW, because another user could place a symbolic link at the predictable name.
  const int fd = ::open(_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (fd < 0) return;
  if (::write(fd, entry.data(), entry.size()) > 0) _bytes = full ? most_bytes : _bytes + entry.size();
  ::close(fd);
} catch (...) {  // out of memory
}

std::string solver_log_file() { return SolverLog::instance().file().string(); }

void send_petsc_errors_to_log() { PHYNNESS_PETSC(PetscPushErrorHandler(on_petsc_error, nullptr)); }

}  // namespace phynness
