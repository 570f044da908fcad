#include <phynness/precompute/sample_rays.hpp>

#include "solve_ray.hpp"

namespace phynness {
std::vector<char> requested_rays(const Scene& scene, const Mesh& mesh, const DatabaseHeader& header) {
  const auto& active = header.sets.active;
  std::vector<char> flags(active.size() * header.directions.size(), 1);
  if (scene.probe.directions != Directions::hemisphere) return flags;
  const Points normals = node_normals(mesh);
  for (std::size_t a = 0; a < active.size(); ++a)
    for (std::size_t d = 0; d < header.directions.size(); ++d) {
      const Eigen::Map<const Eigen::RowVector3d> e(header.directions[d].data());
      // Tangential directions count as inward, independently of rounding.
      flags[a * header.directions.size() + d] &= -normals.row(active[a]).dot(e) > -1e-9;
    }
  return flags;
}

SolvedRays solve_rays(ProbeSolver& solver, const DatabaseHeader& header,
                      const std::vector<std::pair<std::int32_t, std::int32_t>>& which,
                      const std::function<void(std::int64_t)>& progress, const std::function<bool()>& stop) {
  SolvedRays solved;
  solver.set_stop(stop, 0);
  for (const auto& [active, direction] : which) {
    if (stop && stop()) {
      solved.interrupted = true;
      break;
    }
    try {
      if (solved.rays.empty() || solved.rays.back().active != active) {
        const double before = cpu_seconds();
        solver.touch({header.sets.active[static_cast<std::size_t>(active)]});
        solved.node_setup_s.push_back(cpu_seconds() - before);
      }
      solved.rays.push_back(solve_ray(solver, header, active, direction));
    } catch (const Interrupted&) {
      solved.interrupted = true;
      break;
    }
    if (progress) progress(static_cast<std::int64_t>(solved.rays.size()));
  }
  return solved;
}

}  // namespace phynness
