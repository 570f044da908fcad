// Ranks that solve one large body together: one leads, the others lend it memory and time for its
// factorizations.
#pragma once

#include <mpi.h>
#include <petscmat.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace phynness {

/// Consecutive ranks of MPI_COMM_WORLD. The leader holds the body and calls; the others are in serve()
/// meanwhile. What is shared is the factorization (MUMPS distributes it) and its substitutions; kernels stay
/// with the leader.
class Team {
 public:
  /// Collective over MPI_COMM_WORLD. @pre size divides the number of ranks
  explicit Team(int size);
  ~Team();
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

  /// The leader's calls. @param matrix  symmetric, on this process alone, of the same pattern every time
  /// @return false if it could not be factorized
  bool factorize(Mat matrix);
  /// x = matrix^-1 b, of the latest that was factorized.
  void solve(Vec b, Vec x);
  int negative_pivots();

 private:
  enum class Order : std::int64_t { create, factorize, solve, count_negative_pivots, dismiss };
  class Share;
  /// What every member does for an order; from the leader the arguments are the whole matrix's, or vectors.
  std::int64_t obey(Order order, std::int64_t n, Mat matrix, Vec b, Vec x);
  std::int64_t command(Order order, std::int64_t n = 0, Mat matrix = nullptr, Vec b = nullptr,
                       Vec x = nullptr);

  MPI_Comm _comm = MPI_COMM_NULL;
  int _rank = 0, _size = 1;
  std::unique_ptr<Share> _share;
};

}  // namespace phynness
