#include "console.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

namespace phynness::cli {

Progress::Progress(std::string what, std::string unit) : _what(std::move(what)), _unit(std::move(unit)) {
  const char* forced = std::getenv("PHYNNESS_PROGRESS");
  _visible = isatty(STDERR_FILENO) != 0 || (forced != nullptr && std::string_view(forced) == "1");
}

Progress::~Progress() {
  if (_drawn) message("\r\033[K");
}

void Progress::update(std::int64_t done, std::int64_t total) {
  if (!_visible || total <= 0) return;
  const auto now = Clock::now();
  if (_first < 0) {
    _first = done > 0 ? done - 1 : 0;
    _start = now;
  }
  if (_drawn && done < total && now - _last < std::chrono::milliseconds(200)) return;
  _last = now;
  _drawn = true;
  const double seconds = std::chrono::duration<double>(now - _start).count();
  const double rate = seconds > 0.3 ? static_cast<double>(done - _first) / seconds : 0;
  constexpr int width = 24;
  const auto filled = static_cast<std::size_t>(width * done / total);
  message("\r\033[K{} [{}{}] {}/{} {}", _what, std::string(filled, '#'), std::string(width - filled, '.'), done, total,
          _unit);
  if (rate > 0) message(", {:.3g}/s, {} remaining", rate, duration(static_cast<double>(total - done) / rate));
}

namespace {

std::atomic<bool> is_stop_requested{false};
std::atomic<bool> second_signal_kills_process{true};
const char* signal_message = nullptr;
bool has_progress_line = false;
void write_signal_message(const char* kind) {
  for (const char* text : {has_progress_line ? "\r\033[K" : "", kind, signal_message})
    if (write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
}
extern "C" void exit_on_signal(int /*signal*/) {
  write_signal_message("error: ");
  _exit(1);
}
extern "C" void on_signal(int signal) {
  if (!is_stop_requested.exchange(true)) {
    if (signal_message) write_signal_message("");
  } else if (second_signal_kills_process && signal != SIGUSR1) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

void handle_signals(void (*handler)(int), const char* message) {
  signal_message = message;
  has_progress_line = isatty(STDERR_FILENO) != 0;
  // Without SA_RESTART, so that a signal ends the wait for a child process.
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // mpirun passes SIGUSR1 on to its ranks without ending them itself, and batch systems send it before a time limit.
  sigaction(SIGUSR1, &action, nullptr);
  // A terminal that is closed; nohup has it ignored.
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
}

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
    } else if (errno != EINTR) {
      return errno;
    }
  }
  return 0;
}

/// Breaks the lines of a text at spaces to at most 100 bytes and indents continuations. A longer word, such as a path,
/// gets its own line.
std::string wrapped(std::string text) {
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

bool stop_requested() { return is_stop_requested.load(std::memory_order_relaxed); }

void install_stop_handler(bool second_signal_kills, const char* message) {
  second_signal_kills_process = second_signal_kills;
  handle_signals(on_signal, message);
}

void end_at_signals(const char* message) { handle_signals(exit_on_signal, message); }

std::string duration(double seconds) {
  if (seconds < 10) return fmt::format("{:.1f} s", seconds);
  const auto s = std::llround(seconds);
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
  return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

double machine_memory_bytes() {
  return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
}

std::string bytes(double n) {
  if (n < 1e3) return fmt::format("{:.0f} B", n);
  if (n < 1e6) return fmt::format("{:.1f} kB", n / 1e3);
  if (n < 1e9) return fmt::format("{:.1f} MB", n / 1e6);
  return fmt::format("{:.2f} GB", n / 1e9);
}

void prepare_streams() {
  // open() returns the lowest free number. It opens for reading only, so that writing fails as on a closed descriptor.
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor)
    if (fcntl(descriptor, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) break;
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

void print_result_text(fmt::string_view format, fmt::format_args values) {
  const int error = write_all(results, wrapped(fmt::vformat(format, values)));
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
    write_all(STDERR_FILENO, is_advice ? wrapped(text) : text);
  } catch (...) {  // out of memory
  }
}

int finish_streams(int exit_status) {
  if (first_error == 0 || first_error == EPIPE) return exit_status;  // `| head` has read enough
  message(
      "error: results could not be written to stdout: {}\n"
      "  remedy: all files are written; to see the text, run the command again with a writable stdout\n",
      std::generic_category().message(first_error));
  return exit_status == 0 ? 1 : exit_status;
}

}  // namespace phynness::cli
