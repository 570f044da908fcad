// Progress on stderr during a command, and an orderly end after a signal.
#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <functional>
#include <string>

namespace phynness::cli {

/// One line on stderr that is redrawn a few times a second: finished units, rate, remaining time. It is only shown if
/// stderr is a terminal or if the environment variable PHYNNESS_PROGRESS is 1, which a parent process with a terminal
/// sets.
class Progress {
 public:
  explicit Progress(std::string what, std::string unit);
  ~Progress();
  void update(std::int64_t done, std::int64_t total);
  /// For work that counts its parts; this object outlives it.
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
/// For commands that poll stop_requested(). In other commands a signal ends the process at once.
/// @param second_signal_kills  false for a process that must outlive its children
/// @param words  printed at the first signal; they stay valid
void install_stop_handler(bool second_signal_kills = true, const char* words = nullptr);

/// For work that writes nothing before its end: a signal prints "error: " and `words` and ends the process with status
/// 1, also inside of a long computation. @param words  stays valid
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

}  // namespace phynness::cli
