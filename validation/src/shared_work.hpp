// Work that ranks share, item by item, and that a person may end early.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness {

/// Items 0 ... n - 1 in turn to the ranks of a session, so that what is finished early is an even part of
/// all. `stop` is asked after each; an item that throws Interrupted is the last, unfinished. @param progress  items
/// done over all ranks, as rank 0 sees it, and n
/// @return items that this rank finished
inline std::int64_t share_out(const SolverSession& session, std::int64_t n,
                              const std::function<void(std::int64_t, std::int64_t)>& progress,
                              const std::function<bool()>& stop, const std::function<void(std::size_t)>& work) {
  std::int64_t finished = 0;
  for (std::int64_t i = session.rank(); i < n; i += session.size()) {
    try {
      work(static_cast<std::size_t>(i));
    } catch (const Interrupted&) {
      break;
    }
    ++finished;
    if (progress && session.rank() == 0) progress(std::min(n, i + session.size()), n);
    if (stop && stop()) break;
  }
  return finished;
}

}  // namespace phynness
