// Every program that solves needs PETSc and MPI for its whole life, and exactly once.
#include <gtest/gtest.h>

#include <memory>
#include <phynness/precompute/probe_solver.hpp>

namespace {

/// An environment and not a main(), so that listing the tests starts no MPI.
class SolverEnvironment : public ::testing::Environment {
  void SetUp() override { _session = std::make_unique<phynness::SolverSession>(); }
  void TearDown() override { _session.reset(); }

  std::unique_ptr<phynness::SolverSession> _session;
};

[[maybe_unused]] const auto* const environment = ::testing::AddGlobalTestEnvironment(new SolverEnvironment);

}  // namespace
