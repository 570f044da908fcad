// Solves a sample of the rays of a scene in the same way as precompute(), and measures their costs.
#pragma once

#include <cstdint>
#include <functional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <vector>

namespace phynness {

/// Largest resident memory of this process so far.
double peak_memory_bytes();

/// Flags (n_active x n_directions) of the rays that a scene requests; a hemisphere has only inward directions.
std::vector<char> requested_rays(const Scene& scene, const Mesh& mesh, const DatabaseHeader& header);

struct SolvedRays {
  std::vector<Ray> rays;
  std::vector<double> node_setup_s;  ///< CPU time of the preparation of each node
  bool interrupted = false;
};

/// @param which     pairs (index of the active node, index of the direction) in the order of the database
/// @param progress  called after each ray with the number of finished rays
/// @param stop      polled between rays and between iterations; true ends the running solve at once
/// @throws Error
SolvedRays solve_rays(ProbeSolver& solver, const DatabaseHeader& header,
                      const std::vector<std::pair<std::int32_t, std::int32_t>>& which,
                      const std::function<void(std::int64_t)>& progress, const std::function<bool()>& stop);

}  // namespace phynness
