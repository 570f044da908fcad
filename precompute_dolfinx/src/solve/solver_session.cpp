#include <dlfcn.h>
#include <mpi.h>
#include <petscsys.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <thread>

#include "discretization.hpp"
#include "petsc_check.hpp"
#include "study/solver_log.hpp"

namespace phynness {
namespace {

/// Sets environment variables while MPI starts a process without a launcher (a singleton). By default Open MPI starts a
/// server, searches for networks for half a second, and creates a session folder that all singletons of a user share: a
/// process that ends may remove it while another one starts. Variables that the user has set are kept.
class MpiSingletonVariables {
 public:
  MpiSingletonVariables() {
    constexpr std::array launcher_variables = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
    if (std::any_of(launcher_variables.begin(), launcher_variables.end(), std::getenv)) return;
    for (auto& [name, value, is_ours] : _variables) is_ours = !std::getenv(name) && setenv(name, value, 0) == 0;
  }
  ~MpiSingletonVariables() {
    for (const auto& [name, value, is_ours] : _variables)
      if (is_ours) unsetenv(name);
  }
  MpiSingletonVariables(const MpiSingletonVariables&) = delete;
  MpiSingletonVariables& operator=(const MpiSingletonVariables&) = delete;

 private:
  struct Variable {
    const char *name, *value;
    bool is_ours = false;
  };
  std::array<Variable, 3> _variables = {
      {{"OMPI_MCA_ess_singleton_isolated", "1"}, {"OMPI_MCA_orte_create_session_dirs", "0"}, {"OMPI_MCA_pml", "ob1"}}};
};

}  // namespace

SolverSession::SolverSession() {
  const MpiSingletonVariables singleton;
  // PETSc does not get the command line, whose options it would interpret as its own, and does not handle signals,
  // because Ctrl-C ends a run between two rays.
  PHYNNESS_PETSC(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));
  PHYNNESS_PETSC(PetscInitialize(nullptr, nullptr, nullptr, nullptr));
  send_petsc_errors_to_log();
  quiet_logging();
  // For matrices of a few thousand rows a second thread costs more time than it saves, and ranks use all cores.
  if (void* symbol = dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) reinterpret_cast<void (*)(int)>(symbol)(1);
  MPI_Comm_rank(MPI_COMM_WORLD, &_rank);
  MPI_Comm_size(MPI_COMM_WORLD, &_size);
}

SolverSession::~SolverSession() { PetscFinalize(); }

void SolverSession::together(const std::function<void()>& work) const {
  std::string message;
  int kind = -1;
  try {
    work();
  } catch (const Error& error) {
    message = error.what();
    kind = static_cast<int>(error.kind());
  } catch (const std::exception& error) {
    message = error.what();
    kind = static_cast<int>(Error::Kind::failure);
  }
  int first = kind >= 0 ? _rank : _size;
  MPI_Allreduce(MPI_IN_PLACE, &first, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (first == _size) return;
  int length = static_cast<int>(message.size());
  MPI_Bcast(&kind, 1, MPI_INT, first, MPI_COMM_WORLD);
  MPI_Bcast(&length, 1, MPI_INT, first, MPI_COMM_WORLD);
  message.resize(static_cast<std::size_t>(length));
  MPI_Bcast(message.data(), length, MPI_CHAR, first, MPI_COMM_WORLD);
  throw Error(static_cast<Error::Kind>(kind), _rank == 0 ? message : "", "", "");
}

double SolverSession::sum(double value) const {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  return value;
}

bool SolverSession::broadcast(bool value) const {
  int number = value, is_received = _size == 1;
  MPI_Request request = MPI_REQUEST_NULL;
  if (_size > 1) MPI_Ibcast(&number, 1, MPI_INT, 0, MPI_COMM_WORLD, &request);
  while (!is_received) {
    MPI_Test(&request, &is_received, MPI_STATUS_IGNORE);
    if (!is_received) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return number != 0;
}

template <class T>
std::vector<T> SolverSession::gather(const std::vector<T>& values) const {
  const MPI_Datatype type = std::is_same_v<T, double> ? MPI_DOUBLE : MPI_UNSIGNED_CHAR;
  int n = static_cast<int>(values.size());
  std::vector<int> counts(_size), offsets(_size);
  MPI_Gather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<T> all(offsets.back() + counts.back());  // on other ranks all counts are 0
  MPI_Gatherv(values.data(), n, type, all.data(), counts.data(), offsets.data(), type, 0, MPI_COMM_WORLD);
  return all;
}
template std::vector<double> SolverSession::gather(const std::vector<double>&) const;
template std::vector<unsigned char> SolverSession::gather(const std::vector<unsigned char>&) const;

}  // namespace phynness
