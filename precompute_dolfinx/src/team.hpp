// Ranks that solve one large body together: one leads, the others lend it memory and time for its
// factorizations.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "linear_solver.hpp"

namespace phynness {

/// Consecutive ranks of MPI_COMM_WORLD. The leader holds the body and calls; the others are in serve()
/// meanwhile. What is shared is the factorization (MUMPS distributes it) and its substitutions; kernels stay
/// with the leader.
class Team : public LinearSolver {
 public:
  /// Collective over MPI_COMM_WORLD. @pre size divides the number of ranks
  explicit Team(int size);
  ~Team() override;
  Team(const Team&) = delete;

  int size() const { return _size; }
  bool leads() const { return _rank == 0; }

  struct Served {
    double busy_seconds = 0, core_seconds = 0;  ///< wall and CPU time of the work that was asked for
  };
  /// Not for the leader: does what it asks for until it dismisses.
  Served serve();
  /// The leader's last call.
  void dismiss();

  /// The leader's calls. An error of any member is an error of all.
  bool factorize(Mat matrix) override;
  bool solve(Vec b, Vec x) override;
  int negative_pivots() override;
  void reset() override;

 private:
  enum class Order : std::int64_t { create, factorize, solve, count_negative_pivots, reset, dismiss };
  class Share;
  /// What every member does for an order; from the leader the arguments are the whole matrix's, or vectors.
  /// @return a count, or for other orders 1 for success and 0 for failure
  /// @throws Error on the leader, if a member met one
  std::int64_t obey(Order order, std::int64_t n, Mat matrix, Vec b, Vec x);
  std::int64_t do_share(Order order, std::int64_t n, Mat matrix, Vec b, Vec x);
  std::int64_t command(Order order, std::int64_t n = 0, Mat matrix = nullptr, Vec b = nullptr, Vec x = nullptr);

  MPI_Comm _comm = MPI_COMM_NULL;
  int _rank = 0, _size = 1;
  std::unique_ptr<Share> _share;
};

}  // namespace phynness
