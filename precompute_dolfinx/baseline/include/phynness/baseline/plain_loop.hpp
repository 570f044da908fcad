// The solver everyone would write first, as the baseline: SNES Newton as PETSc ships it, the tangent inserted
// entry by entry, MUMPS LU at every iteration, each increment started from the previous one scaled up.
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

/// Node and patch probes of one tool. Same forms, same scaling, same stopping test as ProbeSolver.
class PlainLoop {
 public:
  PlainLoop(const Scene& scene, const Mesh& mesh, const NodeSets& sets);
  ~PlainLoop();

  /// All increments of one ray; those after a failed one are not tried.
  /// @param full_depth_m  displacement of the last of `increments` equal steps
  std::vector<PlainState> ray(std::int32_t node, const Vec3& full_depth_m, int increments);

  SolverCounts counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> _impl;
};

}  // namespace phynness::bench
