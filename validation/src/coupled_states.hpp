// Random rays of one tool between nodes and of two tools, solved for the calibration of bounds.
#pragma once

#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/coupled_bounds.hpp>
#include <random>

namespace phynness {

class CoupledRays {
 public:
  explicit CoupledRays(const LoadedModel& model, const ProbeSpec& probe);
  /// Whether there are places for one tool between nodes, or for two.
  bool possible(int n_tools) const;
  /// Solves a random ray at random places; of pairs every second one is at nodes, and every third one near.
  void solve(ProbeSolver& solver, std::mt19937_64& random, std::int32_t ray, std::int32_t n_tools,
             std::vector<CoupledState>& states) const;

 private:
  phn_tool random_tool(std::mt19937_64& random, bool at_node) const;
  double trained_depth(const phn_tool& tool, const Vec3& direction) const;
  /// Draws a displacement inside the trained range. @return false: nothing is trained there
  bool displace(std::mt19937_64& random, phn_tool& tool) const;
  Eigen::RowVector3d place(const phn_tool& tool) const;

  const LoadedModel& _model;
  std::vector<Eigen::Index> _triangles;
  double _near_m;
};

}  // namespace phynness
