// What a person sees while a command works: progress on stderr, and a polite end on Ctrl-C.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace phynness::cli {

/// One line on stderr, redrawn a few times a second: done, rate, time left. Silent when stderr is no
/// terminal, unless the environment variable PHYNNESS_PROGRESS is 1 (a parent process that has the terminal
/// says so).
class Progress {
 public:
  explicit Progress(std::string what, std::string unit);
  ~Progress();
  void update(std::int64_t done, std::int64_t total);

 private:
  using Clock = std::chrono::steady_clock;
  std::string _what, _unit;
  bool _visible = false, _drawn = false;
  std::int64_t _first = -1;
  Clock::time_point _start = Clock::now(), _last{};
};

/// True once SIGINT, SIGTERM or SIGUSR1 has come. The first signal asks, a second SIGINT or SIGTERM kills.
bool stop_requested();
/// For commands that poll stop_requested(); elsewhere a signal simply ends the program.
/// @param second_signal_kills  false for a process that must outlive its children
void install_stop_handler(bool second_signal_kills = true);

/// "3 min 12 s", "48 s", "2 h 05 min"
std::string duration(double seconds);
/// "12.3 MB"
std::string bytes(double n);

}  // namespace phynness::cli
