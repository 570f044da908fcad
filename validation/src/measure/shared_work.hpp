// Distribution of work over ranks, with an early end.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <phynness/formats/progress.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// Distributes the items 0 ... n - 1 to the ranks round robin, so that the finished items after an early end are an
/// even sample. Each turn begins with the next rank, so that alternating costs are balanced. `stop` is called after
/// each item. An item that throws Interrupted is the last one and does not count as finished.
/// @param progress  receives the finished items of all ranks, as estimated by rank 0, and n
/// @return number of items that this rank has finished
inline std::int64_t distribute(const SolverSession& session, std::int64_t n, const OnProgress& progress,
                               const ShouldStop& stop, const std::function<void(std::size_t)>& work) {
  std::int64_t finished = 0;
  const std::int64_t ranks = session.size();
  for (std::int64_t turn = 0; turn * ranks < n; ++turn) {
    const std::int64_t i = turn * ranks + (session.rank() + turn) % ranks;
    if (i >= n) continue;
    try {
      work(static_cast<std::size_t>(i));
    } catch (const Interrupted&) {
      break;
    }
    ++finished;
    if (progress && session.rank() == 0) progress(std::min(n, (turn + 1) * ranks), n);
    if (stop && stop()) break;
  }
  return finished;
}

}  // namespace phynness
