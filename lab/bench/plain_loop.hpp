// A straightforward solver as the baseline of benchmarks: Newton's method of PETSc SNES with default options, a tangent
// that is inserted entry by entry, MUMPS LU in every iteration, and the scaled previous increment as the initial guess.
#pragma once

#include <memory>
#include <phynness/formats/scene.hpp>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness::bench {

struct PlainState {
  bool converged = false;
  int iterations = 0;
  Vec3 force_N{};
};

/// Node and patch probes of one tool, with the same forms, scaling and stopping test as ProbeSolver.
class PlainLoop {
 public:
  PlainLoop(const Scene& scene, const Mesh& mesh, const NodeSets& sets);
  ~PlainLoop();

  /// Solves the increments of one ray up to the first that fails.
  /// @param full_depth_m  displacement of the last of `increments` equal steps
  std::vector<PlainState> ray(std::int32_t node, const Vec3& full_depth_m, int increments);

  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness::bench
