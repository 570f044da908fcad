// The counter of the next free task: a number on rank 0, which all ranks access by fetch-and-add. On a network without
// hardware support a rank waits until rank 0 calls MPI, which make_progress() does between iterations.
#pragma once

#include <mpi.h>

#include <cstdint>

namespace phynness {

/// Construction and destruction are collective.
class WorkCounter {
 public:
  explicit WorkCounter(MPI_Comm comm) : _comm(comm) {
    int rank = 0;
    MPI_Comm_rank(comm, &rank);
    MPI_Win_allocate(rank == 0 ? 2 * sizeof(std::int64_t) : 0, sizeof(std::int64_t), MPI_INFO_NULL, comm, &_values,
                     &_window);
    if (rank == 0) _values[0] = _values[1] = 0;
    MPI_Barrier(comm);
    MPI_Win_lock_all(0, _window);
  }
  ~WorkCounter() {
    MPI_Win_unlock_all(_window);
    MPI_Barrier(_comm);
    MPI_Win_free(&_window);
  }
  WorkCounter(const WorkCounter&) = delete;

  /// Fetches the next free task.
  std::int64_t next() { return add(0, 1); }
  /// Stops the distribution of tasks, because one rank cannot continue.
  void close() { add(0, std::int64_t{1} << 40); }
  /// Adds finished work without waiting for rank 0.
  void add_done(std::int64_t n) {
    MPI_Accumulate(&n, 1, MPI_INT64_T, 0, 1, 1, MPI_INT64_T, MPI_SUM, _window);
    MPI_Win_flush_local(0, _window);
  }
  /// Lets MPI answer the fetches of other ranks.
  void make_progress() {
    int arrived = 0;
    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, _comm, &arrived, MPI_STATUS_IGNORE);
  }
  /// Finished work of all ranks, as recorded on rank 0.
  std::int64_t done() { return add(1, 0); }

 private:
  std::int64_t add(int slot, std::int64_t n) {
    std::int64_t before = 0;
    MPI_Fetch_and_op(&n, &before, MPI_INT64_T, 0, slot, MPI_SUM, _window);
    MPI_Win_flush(0, _window);
    return before;
  }

  MPI_Comm _comm;
  MPI_Win _window{};
  std::int64_t* _values = nullptr;
};

}  // namespace phynness
