#include "rays.hpp"

#include <cstdio>
#include <ctime>
#include <phynness/precompute/probe_solver.hpp>

namespace phynness::robustness {
namespace {

double cpu_ms() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

void add_ray(ProbeSolver& solver, std::int32_t node, const Vec3& direction, const std::vector<double>& depths,
             Tally& tally) {
  ++tally.rays;
  double ray_min_jacobian = 1;
  solver.follow({direction}, depths, false, [&](std::size_t i, const Response& r) {
    tally.cutbacks += r.cutbacks;
    tally.increments_cut += r.cutbacks > 0;
    tally.iterations += r.iterations;
    if (r.status != Status::converged) {
      ++tally.reasons[r.status];
      tally.failures.push_back({node, direction, depths[i], r.status});
      return false;
    }
    ++tally.reached[i];
    ++tally.states;
    tally.indefinite += r.negative_pivots > 0;
    ray_min_jacobian = std::min(ray_min_jacobian, r.min_jacobian);
    tally.upright += i + 1 == depths.size() && ray_min_jacobian > 0;
    return true;
  });
  tally.min_jacobian = std::min(tally.min_jacobian, ray_min_jacobian);
}

}  // namespace

Tally follow_rays(const Body& body, const std::vector<std::int32_t>& nodes) {
  const ProbeSpec& probe = body.scene.probe;
  std::vector<double> depths;
  for (int i = 1; i <= probe.increments; ++i) depths.push_back(probe.max_displacement_m * i / probe.increments);
  Tally tally;
  tally.reached.assign(depths.size(), 0);
  const double start = cpu_ms();
  ProbeSolver solver(body.scene, body.mesh, body.sets);
  const Points normals = node_normals(body.mesh);
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    solver.touch({nodes[n]});
    for (const Vec3& e : exploratory_directions(probe.directions)) {
      const double outward = normals.row(nodes[n]).dot(Eigen::RowVector3d(e[0], e[1], e[2]));
      if (probe.directions == Directions::hemisphere && outward > 1e-9) continue;
      add_ray(solver, nodes[n], e, depths, tally);
    }
    std::fprintf(stderr, "\r  node %zu of %zu, %.0f s of CPU ", n + 1, nodes.size(), 1e-3 * (cpu_ms() - start));
  }
  std::fprintf(stderr, "\r%40s\r", "");
  tally.cpu_ms = cpu_ms() - start;
  return tally;
}

void print_header(const char* what, const std::vector<std::string>& depths) {
  std::printf("\n%-34s %5s", what, "rays");
  for (const auto& depth : depths) std::printf(" %8s", depth.c_str());
  std::printf("  %8s %8s %9s %9s %9s %9s %10s %7s %8s\n", "J > 0", "inc. cut", "inverted", "diverged", "factoriz.",
              "not finite", "indefinite", "min J", "ms/inc.");
}

void print_row(const std::string& what, const Tally& t, const std::vector<std::size_t>& depths) {
  std::printf("%-34s %5d", what.c_str(), t.rays);
  for (const auto i : depths) std::printf(" %7.1f%%", 100.0 * t.reached[i] / std::max(1, t.rays));
  const auto count = [&](Status status) { return t.reasons.count(status) ? t.reasons.at(status) : 0; };
  std::printf("  %7.1f%% %8d %9d %9d %9d %10d %9.1f%% %7.3f %8.1f\n", 100.0 * t.upright / std::max(1, t.rays),
              t.increments_cut, count(Status::inverted), count(Status::diverged), count(Status::factorization),
              count(Status::not_finite), 100.0 * t.indefinite / std::max(1, t.states), t.min_jacobian,
              t.cpu_ms / std::max(1, t.states));
  std::fflush(stdout);
}

void print_failures(const Tally& tally) {
  for (const auto& f : tally.failures)
    std::printf("    node %d, direction (%.2f, %.2f, %.2f): %s at %.4g m\n", f.node, f.direction[0], f.direction[1],
                f.direction[2], name(f.reason), f.depth_m);
}

}  // namespace phynness::robustness
