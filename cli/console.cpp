#include "console.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

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
std::atomic<bool> stop{false};
std::atomic<bool> second_kills{true};
const char* last_words = nullptr;
bool clears_line = false;  // of a progress bar
void say(const char* kind) {
  for (const char* text : {clears_line ? "\r\033[K" : "", kind, last_words})
    if (write(STDERR_FILENO, text, std::strlen(text)) < 0) break;
}
extern "C" void end_now(int /*signal*/) {
  say("error: ");
  _exit(1);
}
extern "C" void on_signal(int signal) {
  if (!stop.exchange(true)) {
    if (last_words) say("");
  } else if (second_kills && signal != SIGUSR1) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

void handle_signals(void (*handler)(int), const char* words) {
  last_words = words;
  clears_line = isatty(STDERR_FILENO) != 0;
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
}  // namespace

bool stop_requested() { return stop.load(std::memory_order_relaxed); }

void install_stop_handler(bool second_signal_kills, const char* words) {
  second_kills = second_signal_kills;
  handle_signals(on_signal, words);
}

void end_at_signals(const char* words) { handle_signals(end_now, words); }

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

}  // namespace phynness::cli
