#include <ctime>
#include <phynness/precompute/sample_rays.hpp>

namespace phynness {
namespace {

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void append(const Response& response, const DatabaseHeader& header, double seconds, Ray& ray) {
  const bool good = response.status == Status::converged;
  ray.status.push_back(response.status);
  ray.iterations.push_back(response.iterations);
  ray.cutbacks.push_back(response.cutbacks);
  ray.seconds.push_back(seconds);
  ray.energy.push_back(good ? response.energy_J : 0);
  ray.negative_pivots.push_back(good ? response.negative_pivots : 0);
  ray.min_jacobian.push_back(good ? response.min_jacobian : 0);
  for (std::size_t k = 0; k < 3; ++k) ray.force.push_back(good ? response.force_N[0][k] : 0);
  for (int k = 0; header.tangents && k < 9; ++k)
    ray.tangent.push_back(good ? response.tangent_N_per_m(k / 3, k % 3) : 0);
  for (const auto node : header.sets.output)
    for (int k = 0; k < 3; ++k) ray.displacement.push_back(good ? response.displacement_m(node, k) : 0);
}

}  // namespace

std::vector<char> requested_rays(const Scene& scene, const Mesh& mesh, const DatabaseHeader& header) {
  const auto& active = header.sets.active;
  std::vector<char> flags(active.size() * header.directions.size(), 1);
  if (scene.probe.directions != Directions::hemisphere) return flags;
  const Points normals = node_normals(mesh);
  for (std::size_t a = 0; a < active.size(); ++a)
    for (std::size_t d = 0; d < header.directions.size(); ++d) {
      const Eigen::Map<const Eigen::RowVector3d> e(header.directions[d].data());
      // Tangential directions count as inward, whichever way rounding goes.
      flags[a * header.directions.size() + d] = -normals.row(active[a]).dot(e) > -1e-9;
    }
  return flags;
}

SolvedRays solve_rays(ProbeSolver& solver, const DatabaseHeader& header,
                      const std::vector<std::pair<std::int32_t, std::int32_t>>& which,
                      const std::function<void(std::int64_t)>& progress, const std::function<bool()>& stop) {
  SolvedRays solved;
  for (const auto& [active, direction] : which) {
    if (stop && stop()) {
      solved.interrupted = true;
      break;
    }
    if (solved.rays.empty() || solved.rays.back().active != active) {
      const double before = cpu_seconds();
      solver.touch({header.sets.active[static_cast<std::size_t>(active)]});
      solved.node_setup_s.push_back(cpu_seconds() - before);
    }
    Ray ray;
    ray.active = active;
    ray.direction = direction;
    double before = cpu_seconds();
    solver.follow({header.directions[static_cast<std::size_t>(direction)]}, header.magnitudes_m,
                  header.tangents, [&](std::size_t, const Response& response) {
                    const double now = cpu_seconds();
                    append(response, header, now - before, ray);
                    before = now;
                    return true;
                  });
    solved.rays.push_back(std::move(ray));
    if (progress) progress(static_cast<std::int64_t>(solved.rays.size()));
  }
  return solved;
}

}  // namespace phynness
