// PETSc and MPI are initialized exactly once per test program.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <phynness/precompute/probe_solver.hpp>

#include "solver_test_session.hpp"

#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/lsan_interface.h>
/// Open MPI 4.1 does not free the 122 kB that it allocates while it starts and ends, some of it in plugins that are
/// unloaded by then, whose stacks name no library that a list of suppressions could name.
using NoLeakCheck = __lsan::ScopedDisabler;
#else
struct NoLeakCheck {
  NoLeakCheck() {}
};
#endif

namespace {

std::unique_ptr<phynness::SolverSession> session;

bool has_avx512() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

/// An environment and not a main(), so that listing the tests starts no MPI.
class SolverEnvironment : public ::testing::Environment {
  void SetUp() override {
    const char* kernels = std::getenv("OPENBLAS_CORETYPE");
    if (kernels && std::strcmp(kernels, "SkylakeX") == 0 && !has_avx512())
      GTEST_SKIP() << "this processor has no AVX-512, which OpenBLAS's kernels for SkylakeX need";
    // One process that talks to nobody: Open MPI need not look for networks, which takes longer than most tests.
    ::setenv("OMPI_MCA_pml", "ob1", 0);
    ::setenv("OMPI_MCA_btl", "self", 0);
    const NoLeakCheck starting;
    session = std::make_unique<phynness::SolverSession>();
  }
  void TearDown() override {
    const NoLeakCheck ending;
    session.reset();
  }
};

[[maybe_unused]] const auto* const environment = ::testing::AddGlobalTestEnvironment(new SolverEnvironment);

}  // namespace

const phynness::SolverSession& phynness::test::solver_session() { return *session; }
