// Teams of ranks for large bodies: one rank leads, and the others provide memory and time for its factorizations.
#pragma once

#include <mpi.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "linear_solver.hpp"

namespace phynness {

/// Consecutive ranks of MPI_COMM_WORLD. The leader has the body and calls the functions of LinearSolver; meanwhile the
/// other members are in serve(). Factorizations, distributed by MUMPS, and substitutions are shared; kernels run on the
/// leader.
class Team : public LinearSolver {
 public:
  /// Collective over MPI_COMM_WORLD. @pre size divides the number of ranks
  explicit Team(int size);
  ~Team() override;
  Team(const Team&) = delete;

  int size() const { return _size; }
  bool leads() const { return _rank == 0; }

  struct Served {
    double busy_seconds = 0, core_seconds = 0;  ///< wall and CPU time of the executed orders
  };
  /// Called by all members except the leader: executes orders of the leader until dismiss().
  Served serve();
  /// The last call of the leader; ends serve() on the other members.
  void dismiss();

  /// Called by the leader. An error of any member is an error of the team.
  bool factorize(Mat matrix) override;
  bool solve(Vec b, Vec x) override;
  int negative_pivots() override;
  void reset() override;

 private:
  enum class Order : std::int64_t { create, factorize, solve, count_negative_pivots, reset, dismiss };
  class Share;
  /// Executes an order on a member. On the leader the arguments are the complete matrix or vectors.
  /// @return a count or, for other orders, 1 for success and 0 for failure
  /// @throws Error on the leader if any member has an error
  std::int64_t obey(Order order, std::int64_t n, Mat matrix, Vec b, Vec x);
  std::int64_t do_share(Order order, std::int64_t n, Mat matrix, Vec b, Vec x);
  std::int64_t command(Order order, std::int64_t n = 0, Mat matrix = nullptr, Vec b = nullptr, Vec x = nullptr);

  MPI_Comm _comm = MPI_COMM_NULL;
  int _rank = 0, _size = 1;
  std::unique_ptr<Share> _share;
};

}  // namespace phynness
