// Parallel execution of jobs on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace phynness {

/// Runs job(i) for i = 0 ... n - 1 on `threads` threads. The first exception stops all threads and is rethrown.
template <class Job>
void for_each_index(std::int32_t n, int threads, const Job& job) {
  std::atomic<std::int32_t> next{0};
  std::atomic<bool> stop{false};
  std::exception_ptr problem;
  std::mutex problem_mutex;
  const auto work = [&] {
    for (std::int32_t i = next++; i < n && !stop; i = next++) {
      try {
        job(i);
      } catch (...) {
        const std::lock_guard lock(problem_mutex);
        if (!problem) problem = std::current_exception();
        stop = true;
      }
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int t = 1; t < std::min(threads, n); ++t) helpers.emplace_back(work);
    work();
  }
  if (problem) std::rethrow_exception(problem);
}

}  // namespace phynness
