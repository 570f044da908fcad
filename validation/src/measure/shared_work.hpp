// Distribution of items of work over ranks, which can be ended early.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <phynness/formats/progress.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// Distributes the items 0 ... n - 1 to the ranks of a session in turn, so that the items finished before an early end
/// are an even sample of all. Each turn begins with the next rank, so that items of which every second one takes longer
/// are shared evenly. `stop` is called after each item. An item that throws Interrupted is the last one and not
/// finished.
/// @param progress  receives the finished items of all ranks, as estimated by rank 0, and n
/// @return number of items that this rank finished
inline std::int64_t share_out(const SolverSession& session, std::int64_t n, const OnProgress& progress,
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
