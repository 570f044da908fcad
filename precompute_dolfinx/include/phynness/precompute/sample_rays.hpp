// A few rays of a scene, solved as precompute() solves them, with what they cost.
#pragma once

#include <cstdint>
#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <vector>

namespace phynness {

/// Flags n_active x n_directions: which rays a scene asks for (hemisphere: those that press inward) and are
/// no mirror images of others.
std::vector<char> requested_rays(const Scene& scene, const Mesh& mesh, const DatabaseHeader& header);

struct SolvedRays {
  std::vector<Ray> rays;
  std::vector<double> node_setup_s;  ///< CPU time of turning to a node, one entry per node
  bool interrupted = false;
};

/// @param which  pairs (index of the active node, index of the direction) in the database's order
/// @param progress  called after each ray with the number done
/// @param stop      polled between rays
/// @throws Error
SolvedRays solve_rays(ProbeSolver& solver, const DatabaseHeader& header,
                      const std::vector<std::pair<std::int32_t, std::int32_t>>& which,
                      const std::function<void(std::int64_t)>& progress, const std::function<bool()>& stop);

}  // namespace phynness
