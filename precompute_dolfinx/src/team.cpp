#include "team.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "factorization.hpp"
#include "petsc_check.hpp"
#include "solve_ray.hpp"
#include "solver_log.hpp"

namespace phynness {
namespace {

using Clock = std::chrono::steady_clock;

/// Handles the case that only this member has an error: the other members then wait in a collective call that never
/// ends.
void wait_for_the_others(MPI_Request& request, const std::string& trouble) {
  constexpr auto longest = std::chrono::minutes(10);  // far longer than a factorization
  const auto start = Clock::now();
  for (int arrived = 0; !arrived;) {
    MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
    if (!arrived && Clock::now() - start > longest) {
      std::fprintf(stderr,
                   "error: a team of ranks cannot continue: %s\n  remedy: finished rays are kept; continue with "
                   "--resume\n",
                   trouble.c_str());
      MPI_Abort(MPI_COMM_WORLD, 1);
    }
    if (!arrived) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

/// A member's rows of the matrix and its part of the factors. All functions are collective; arguments are only used on
/// the leader and are null on other members.
class Team::Share {
 public:
  Share(MPI_Comm comm, std::int64_t n, Mat matrix);

  bool factorize(Mat matrix);
  bool solve(Vec b, Vec x);
  int negative_pivots() { return _factorization.negative_pivots(); }

 private:
  MPI_Comm _comm;
  bool _leads = false;
  PetscMat _matrix;
  PetscVec _b, _x;
  Factorization _factorization;
  std::vector<PetscScalar> _values;           ///< of this member's rows
  std::vector<int> _first_row, _n_rows;       ///< per member
  std::vector<int> _first_entry, _n_entries;  ///< per member; on the leader only
};

Team::Share::Share(MPI_Comm comm, std::int64_t n, Mat matrix) : _comm(comm) {
  int size = 0, rank = 0;
  MPI_Comm_size(comm, &size);
  MPI_Comm_rank(comm, &rank);
  _leads = rank == 0;
  for (int r = 0; r < size; ++r) {
    _first_row.push_back(static_cast<int>(n * r / size));
    _n_rows.push_back(static_cast<int>(n * (r + 1) / size) - _first_row.back());
  }
  std::vector<int> length(static_cast<std::size_t>(_n_rows[static_cast<std::size_t>(rank)]));
  std::vector<int> all_lengths, all_columns;
  if (_leads) {
    const CsrPattern whole(matrix);
    for (PetscInt i = 0; i < whole.n; ++i) all_lengths.push_back(whole.row_start[i + 1] - whole.row_start[i]);
    all_columns.assign(whole.column, whole.column + whole.row_start[whole.n]);
    for (std::size_t r = 0; r < _n_rows.size(); ++r) {
      _first_entry.push_back(whole.row_start[_first_row[r]]);
      _n_entries.push_back(whole.row_start[_first_row[r] + _n_rows[r]] - _first_entry.back());
    }
  }
  MPI_Scatterv(all_lengths.data(), _n_rows.data(), _first_row.data(), MPI_INT, length.data(),
               static_cast<int>(length.size()), MPI_INT, 0, _comm);
  std::vector<PetscInt> row_start{0};
  for (const int l : length) row_start.push_back(row_start.back() + l);
  std::vector<int> received(static_cast<std::size_t>(row_start.back()));
  MPI_Scatterv(all_columns.data(), _n_entries.data(), _first_entry.data(), MPI_INT, received.data(),
               static_cast<int>(received.size()), MPI_INT, 0, _comm);
  const std::vector<PetscInt> column(received.begin(), received.end());
  _values.assign(column.size(), 0.0);
  const auto rows = static_cast<PetscInt>(length.size());
  PHYNNESS_PETSC(MatCreateMPIAIJWithArrays(_comm, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, row_start.data(),
                                           column.data(), _values.data(), _matrix.address()));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
  PHYNNESS_PETSC(MatCreateVecs(_matrix, _x.address(), _b.address()));
}

bool Team::Share::factorize(Mat matrix) {
  const PetscScalar* all = nullptr;  // read-only, because write access would mark the matrix as changed
  if (_leads) PHYNNESS_PETSC(MatSeqAIJGetArrayRead(matrix, &all));
  MPI_Scatterv(all, _n_entries.data(), _first_entry.data(), MPIU_SCALAR, _values.data(),
               static_cast<int>(_values.size()), MPIU_SCALAR, 0, _comm);
  if (_leads) PHYNNESS_PETSC(MatSeqAIJRestoreArrayRead(matrix, &all));
  PHYNNESS_PETSC(MatUpdateMPIAIJWithArray(_matrix, _values.data()));
  return _factorization.factorize(_matrix);
}

bool Team::Share::solve(Vec b, Vec x) {
  const PetscScalar* from = nullptr;
  PetscScalar *to = nullptr, *mine = nullptr;
  PetscInt rows = 0;
  PHYNNESS_PETSC(VecGetLocalSize(_b, &rows));
  if (_leads) PHYNNESS_PETSC(VecGetArrayRead(b, &from));
  PHYNNESS_PETSC(VecGetArray(_b, &mine));
  MPI_Scatterv(from, _n_rows.data(), _first_row.data(), MPIU_SCALAR, mine, static_cast<int>(rows), MPIU_SCALAR, 0,
               _comm);
  PHYNNESS_PETSC(VecRestoreArray(_b, &mine));
  if (_leads) PHYNNESS_PETSC(VecRestoreArrayRead(b, &from));
  const bool good = _factorization.solve(_b, _x);
  if (_leads) PHYNNESS_PETSC(VecGetArray(x, &to));
  PHYNNESS_PETSC(VecGetArray(_x, &mine));
  MPI_Gatherv(mine, static_cast<int>(rows), MPIU_SCALAR, to, _n_rows.data(), _first_row.data(), MPIU_SCALAR, 0, _comm);
  PHYNNESS_PETSC(VecRestoreArray(_x, &mine));
  if (_leads) PHYNNESS_PETSC(VecRestoreArray(x, &to));
  return good;
}

Team::Team(int size) : _size(size) {
  int world = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &world);
  MPI_Comm_split(MPI_COMM_WORLD, world / size, world, &_comm);
  MPI_Comm_rank(_comm, &_rank);
}

Team::~Team() {
  _share.reset();
  MPI_Comm_free(&_comm);
}

Team::Served Team::serve() {
  Served served;
  for (;;) {
    std::int64_t order[2];
    MPI_Request request;
    MPI_Ibcast(order, 2, MPI_INT64_T, 0, _comm, &request);
    // Between orders the leader computes for milliseconds, during which a waiting member sleeps.
    for (int arrived = 0; !arrived;) {
      MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
      if (!arrived) std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
    if (static_cast<Order>(order[0]) == Order::dismiss) return served;
    const auto start = Clock::now();
    const double core = cpu_seconds();
    obey(static_cast<Order>(order[0]), order[1], nullptr, nullptr, nullptr);
    served.busy_seconds += std::chrono::duration<double>(Clock::now() - start).count();
    served.core_seconds += cpu_seconds() - core;
  }
}

std::int64_t Team::command(Order order, std::int64_t n, Mat matrix, Vec b, Vec x) {
  std::int64_t message[] = {static_cast<std::int64_t>(order), n};
  MPI_Request request;
  MPI_Ibcast(message, 2, MPI_INT64_T, 0, _comm, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
  return order == Order::dismiss ? 0 : obey(order, n, matrix, b, x);
}

void Team::dismiss() { command(Order::dismiss); }

bool Team::factorize(Mat matrix) {
  if (!_share) {
    PetscInt n = 0;
    PHYNNESS_PETSC(MatGetSize(matrix, &n, nullptr));
    command(Order::create, n, matrix);
  }
  return command(Order::factorize, 0, matrix) != 0;
}

bool Team::solve(Vec b, Vec x) { return _share && command(Order::solve, 0, nullptr, b, x) != 0; }

int Team::negative_pivots() {
  if (!_share) throw failure("pivots cannot be counted without factors", "", "please report this defect");
  return static_cast<int>(command(Order::count_negative_pivots));
}

void Team::reset() {
  if (_share) command(Order::reset);
}

std::int64_t Team::do_share(Order order, std::int64_t n, Mat matrix, Vec b, Vec x) {
  switch (order) {
    case Order::create:
      _share = std::make_unique<Share>(_comm, n, matrix);
      return 1;
    case Order::factorize:
      return _share->factorize(matrix) ? 1 : 0;
    case Order::solve:
      return _share->solve(b, x) ? 1 : 0;
    case Order::count_negative_pivots:
      return _share->negative_pivots();
    case Order::reset:
      _share.reset();
      return 1;
    case Order::dismiss:
      break;
  }
  return 0;
}

std::int64_t Team::obey(Order order, std::int64_t n, Mat matrix, Vec b, Vec x) {
  std::string trouble;
  std::int64_t result = 0;
  try {
    result = do_share(order, n, matrix, b, x);
  } catch (const std::exception& error) {
    trouble = error.what();
  }
  // A failure of MUMPS occurs on all members. All members must agree on the result; otherwise some would have factors
  // at the next order and some would not.
  std::array<std::int64_t, 2> agreed{trouble.empty() ? 1 : 0, result};
  MPI_Request request;
  MPI_Iallreduce(MPI_IN_PLACE, agreed.data(), 2, MPI_INT64_T, MPI_MIN, _comm, &request);
  if (trouble.empty()) {
    MPI_Wait(&request, MPI_STATUS_IGNORE);
  } else {
    SolverLog::instance().write(trouble);
    wait_for_the_others(request, trouble);
  }
  if (agreed[0] != 0) return agreed[1];
  _share.reset();
  if (!leads()) return 0;
  throw failure("a factorization shared by several ranks failed",
                trouble.empty() ? "another rank of the team has an error" : trouble,
                "give each rank more memory, or use fewer ranks per node");
}

}  // namespace phynness
