#include "solve_ray.hpp"

#include <ctime>
#include <exception>

#include "solver_log.hpp"

namespace phynness {
namespace {

void store(const Response& response, std::size_t i, const DatabaseHeader& header, double seconds, Ray& ray) {
  ray.status[i] = response.status;
  ray.iterations[i] = response.iterations;
  ray.cutbacks[i] = response.cutbacks;
  ray.seconds[i] = seconds;
  if (response.status != Status::converged) return;
  for (std::size_t k = 0; k < 3; ++k) ray.force[3 * i + k] = response.force_N[0][k];
  ray.energy[i] = response.energy_J;
  for (int k = 0; header.tangents && k < 9; ++k)
    ray.tangent[9 * i + static_cast<std::size_t>(k)] = response.tangent_N_per_m(k / 3, k % 3);
  ray.negative_pivots[i] = response.negative_pivots;
  ray.min_jacobian[i] = response.min_jacobian;
  const auto& output = header.sets.output;
  Points::Map(ray.displacement.data() + 3 * i * output.size(), std::ssize(output), 3) =
      response.displacement_m(output, Eigen::all);
  for (std::size_t f = 0; f < ray.fields.size(); ++f)
    Eigen::VectorXd::Map(ray.fields[f].data() + i * output.size(), std::ssize(output)) =
        response.fields(output, static_cast<Eigen::Index>(f));
}

/// @param n_stored  number of increments with a result, which is kept if this function throws
void follow_ray(ProbeSolver& solver, const DatabaseHeader& header, const RayLimits& limits, Ray& ray,
                std::size_t& n_stored) {
  double before = cpu_seconds();
  ray.end = solver.follow(
      {header.directions[static_cast<std::size_t>(ray.direction)]}, header.magnitudes_m, header.tangents,
      [&](std::size_t i, const Response& response) {
        const double now = cpu_seconds();
        store(response, i, header, now - before, ray);
        before = now;
        n_stored = i + 1;
        return true;
      },
      limits);
}

/// Marks the increments from `first` on as not solved.
void end_ray(const DatabaseHeader& header, Ray& ray, std::size_t first) {
  ray.end = {EndReason::solver, first > 0 ? header.magnitudes_m[first - 1] : 0.0, 0, 0};
  for (std::size_t i = first; i < ray.status.size(); ++i)
    ray.status[i] = i == first ? Status::library_error : Status::after_failure;
}

}  // namespace

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void recover(ProbeSolver& solver) {
  try {
    solver.recover();
  } catch (const std::exception& error) {
    SolverLog::instance().write(error.what());
  }
}

Ray failed_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction) {
  Ray ray = empty_ray(header, active, direction);
  end_ray(header, ray, 0);
  return ray;
}

Ray solve_ray(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t active, std::int32_t direction) {
  Ray ray = empty_ray(header, active, direction);
  std::size_t n_stored = 0;
  try {
    follow_ray(solver, header, solver.limits_of_rays(), ray, n_stored);
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    SolverLog::instance().write(error.what());
    end_ray(header, ray, n_stored);
    recover(solver);
  }
  return ray;
}

AtRest response_at_rest(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t point) {
  const auto response = solver.single_tool_at_rest(header.sets.linear[static_cast<std::size_t>(point)]);
  AtRest stored;
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(stored.stiffness_N_per_m.data()) = response.stiffness_N_per_m;
  for (int along = 0; along < 3; ++along)
    for (const auto node : header.sets.output)
      for (int k = 0; k < 3; ++k) stored.displacement.push_back(response.sensitivity(3 * node + k, along));
  return stored;
}

}  // namespace phynness
