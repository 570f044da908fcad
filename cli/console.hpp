// Output of a command: results on stdout, messages and progress on stderr. A failed write does not end the work.
// Signals request an orderly end.
#pragma once

#include <fmt/core.h>

#include <chrono>
#include <concepts>
#include <cstdint>
#include <functional>
#include <phynness/formats/printable.hpp>
#include <string>
#include <string_view>
#include <type_traits>

namespace phynness::cli {

/// One line on stderr that is redrawn a few times a second: finished units, rate, remaining time. It is only shown if
/// stderr is a terminal or if the environment variable PHYNNESS_PROGRESS is 1, which a parent process with a terminal
/// sets.
class Progress {
 public:
  explicit Progress(std::string what, std::string unit);
  ~Progress();
  void update(std::int64_t done, std::int64_t total);
  /// A function that updates this object, which must outlive it.
  std::function<void(std::int64_t, std::int64_t)> counter() {
    return [this](std::int64_t done, std::int64_t total) { update(done, total); };
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string _what, _unit;
  bool _visible = false, _drawn = false;
  std::int64_t _first = -1;
  Clock::time_point _start = Clock::now(), _last{};
};

/// True after SIGINT, SIGTERM, SIGUSR1 or SIGHUP, unless SIGHUP was ignored from the start. A second one, other than
/// SIGUSR1, kills the process.
bool stop_requested();
/// Lets signals set stop_requested(). Without this call a signal ends the process at once.
/// @param second_signal_kills  false for a process that must outlive its children
/// @param words  text that is printed at the first signal; it must stay valid
void install_stop_handler(bool second_signal_kills = true, const char* words = nullptr);

/// Lets a signal print "error: " and `words` and end the process with status 1, also within a long computation.
/// Suitable while nothing is written. @param words  must stay valid
void end_at_signals(const char* words);

/// "3 min 12 s", "48 s", "2 h 05 min"
std::string duration(double seconds);
double machine_memory_bytes();
/// "12.3 MB"
std::string bytes(double n);
template <std::integral Count>
std::string bytes(Count n) {
  return bytes(static_cast<double>(n));
}

/// Removes control characters from texts; returns numbers unchanged.
template <class T>
auto shown(const T& value) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return printable(std::string_view(value));
  else
    return value;
}

/// Must be called first. Opens standard descriptors that are closed, because otherwise the next opened file would get
/// such a number and messages would be written into it. Writing to these descriptors still fails. The signals of a
/// closed pipe and of the file size limit are ignored, so that they become failed writes.
void prepare_streams();

void print_result_text(fmt::string_view format, fmt::format_args values);
void message_text(fmt::string_view format, fmt::format_args values) noexcept;

/// Writes to stdout in lines of at most 100 bytes, broken at spaces. finish_streams() reports a failed write.
/// A line that is printed in parts is not broken.
template <class... T>
void print_result(fmt::format_string<T...> format, const T&... values) {
  const auto print = [&](const auto&... safe) { print_result_text(format, fmt::make_format_args(safe...)); };
  print(shown(values)...);
}

/// Writes to stderr; lines of notes and warnings are broken as results are. A failed write is ignored, because there is
/// no other stream to report it.
template <class... T>
void message(fmt::format_string<T...> format, const T&... values) noexcept try {
  const auto print = [&](const auto&... safe) { message_text(format, fmt::make_format_args(safe...)); };
  print(shown(values)...);
} catch (...) {  // no memory for a copy
}

/// From here on print_result() writes to stderr, so that stdout contains only what write_stdout() is given.
void print_results_on_stderr();
bool results_are_on_stderr();
/// Writes data to stdout. finish_streams() reports a failed write.
/// @return false after a failed write
bool write_stdout(std::string_view text);

/// Must be called last. Reports on stderr if results could not be written to stdout.
/// @return `exit_status`, or 1 instead of 0 if results are lost
int finish_streams(int exit_status);

}  // namespace phynness::cli
