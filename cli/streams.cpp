#include "console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <system_error>

namespace phynness::cli {
namespace {

constexpr const char* told_by_parent = "PHYNNESS_STDOUT_REPORTED_BY_PARENT";

/// True in a child process whose parent reports failed writes to stdout.
bool parent_reports = false;

/// Where print_result() writes.
int results = STDOUT_FILENO;

/// errno of the first failed write to stdout; 0: none.
int first_error = 0;

/// Does not use stdio, because PetscFinalize() fails if text remains in the buffer of an unwritable stdout.
/// @return 0, or errno
int write_all(int descriptor, std::string_view text) noexcept {
  const char *at = text.data(), *end = at + text.size();
  while (at != end) {
    const auto n = write(descriptor, at, static_cast<std::size_t>(end - at));
    if (n >= 0) {
      at += n;
    } else if (errno == EAGAIN) {  // a terminal that another program has made non-blocking
      pollfd ready{descriptor, POLLOUT, 0};
      poll(&ready, 1, -1);
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

/// The text with its lines broken at spaces to at most 100 bytes; the rest of a line is indented. A word that is
/// longer, such as a path, has a line of its own.
std::string in_lines(std::string text) {
  constexpr std::size_t width = 100;
  for (std::size_t begin = 0; begin < text.size();) {
    const auto indent = std::min(text.find_first_not_of(' ', begin), text.size()) - begin + 2;
    for (std::size_t end = 0; (end = std::min(text.find('\n', begin), text.size())) - begin > width;) {
      auto space = text.rfind(' ', begin + width);
      if (space == std::string::npos || space < begin + indent) space = text.find(' ', begin + width);
      if (space >= end) break;
      text[space] = '\n';
      begin = space + 1;
      text.insert(begin, indent, ' ');
    }
    begin = std::min(text.find('\n', begin), text.size()) + 1;
  }
  return text;
}

}  // namespace

void prepare_streams() {
  parent_reports = std::getenv(told_by_parent) != nullptr;
  // open() returns the lowest free number. It opens for reading only, so that writing fails as on a closed descriptor.
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor)
    if (fcntl(descriptor, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) break;
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void print_result_text(fmt::string_view format, fmt::format_args values) {
  const int error = write_all(results, in_lines(fmt::vformat(format, values)));
  if (first_error == 0 && results == STDOUT_FILENO) first_error = error;
}

void print_results_on_stderr() { results = STDERR_FILENO; }
bool results_are_on_stderr() { return results == STDERR_FILENO; }

bool write_stdout(std::string_view text) {
  if (first_error == 0) first_error = write_all(STDOUT_FILENO, text);
  return first_error == 0;
}

void message_text(fmt::string_view format, fmt::format_args values) noexcept {
  try {
    const auto text = fmt::vformat(format, values);
    const bool is_advice = text.starts_with("note: ") || text.starts_with("warning: ");
    write_all(STDERR_FILENO, is_advice ? in_lines(text) : text);
  } catch (...) {  // out of memory
  }
}

void report_stdout_for_children() { setenv(told_by_parent, "1", 1); }

int finish_streams(int exit_status) {
  if (first_error == 0 || parent_reports) return exit_status;
  message(
      "error: results could not be written to stdout: {}\n"
      "  remedy: all files are written; to see the text, run the command again with a writable stdout\n",
      std::generic_category().message(first_error));
  return exit_status == 0 ? 1 : exit_status;
}

}  // namespace phynness::cli
