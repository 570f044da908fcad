#include <mpi.h>

#include <chrono>
#include <ctime>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/precompute/precompute.hpp>

#include "work_counter.hpp"

namespace phynness {
namespace {

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Ray empty_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction) {
  const std::size_t n = header.magnitudes_m.size();
  Ray ray;
  ray.active = active;
  ray.direction = direction;
  ray.status.assign(n, Status::not_requested);
  ray.force.assign(3 * n, 0.0);
  ray.energy.assign(n, 0.0);
  if (header.tangents) ray.tangent.assign(9 * n, 0.0);
  ray.negative_pivots.assign(n, 0);
  ray.iterations.assign(n, 0);
  ray.cutbacks.assign(n, 0);
  ray.min_jacobian.assign(n, 0.0);
  ray.seconds.assign(n, 0.0);
  ray.displacement.assign(3 * n * header.sets.output.size(), 0.0);
  return ray;
}

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
  for (std::size_t j = 0; j < output.size(); ++j)
    for (int k = 0; k < 3; ++k)
      ray.displacement[3 * (i * output.size() + j) + static_cast<std::size_t>(k)] =
          response.displacement_m(output[j], k);
}

Ray solve_ray(ProbeSolver& solver, const DatabaseHeader& header, std::int32_t active, std::int32_t direction,
              bool requested) {
  Ray ray = empty_ray(header, active, direction);
  if (!requested) return ray;
  double before = cpu_seconds();
  solver.follow({header.directions[static_cast<std::size_t>(direction)]}, header.magnitudes_m,
                header.tangents, [&](std::size_t i, const Response& response) {
                  const double now = cpu_seconds();
                  store(response, i, header, now - before, ray);
                  before = now;
                  return true;
                });
  return ray;
}

}  // namespace

DatabaseHeader database_header(const Scene& scene, const Mesh& mesh, const NodeSets& sets) {
  DatabaseHeader header;
  header.mesh = mesh;
  header.sets = sets;
  header.directions = exploratory_directions(scene.probe.directions);
  for (int i = 1; i <= scene.probe.increments; ++i)
    header.magnitudes_m.push_back(scene.probe.max_displacement_m * i / scene.probe.increments);
  header.tangents = scene.database.tangents;
  header.float64 = scene.database.float64;
  header.scene_text = scene.text;
  header.scene_name = scene.source_name;
  header.scene_folder = scene.mesh.file.parent_path().string();
  header.physics_hash = physics_hash(scene);
  header.mesh_hash = mesh_hash(mesh);
  header.software_version = software_version();
  return header;
}

PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh,
                            const NodeSets& sets, const std::filesystem::path& file, bool resume,
                            const PrecomputeProgress& progress, const std::function<bool()>& stop) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start = cpu_seconds();
  const auto header = database_header(scene, mesh, sets);
  const auto n_active = static_cast<std::int64_t>(sets.active.size());
  const auto n_directions = static_cast<std::int64_t>(header.directions.size());
  const MirroredRays mirrored(header);

  std::vector<char> logged(static_cast<std::size_t>(n_active * n_directions), 0);
  int complete = 0;
  std::optional<ProbeSolver> probe_solver;
  session.together([&] {
    // Before there is a file: a scene that cannot be solved must not leave one behind.
    probe_solver.emplace(scene, mesh, sets);
    if (session.rank() != 0) return;
    DatabaseWriter::create(file, header, resume);
    complete = Database::is_complete(file) ? 1 : 0;
    if (!complete) logged = DatabaseWriter::logged(file, header);
  });
  MPI_Bcast(&complete, 1, MPI_INT, 0, MPI_COMM_WORLD);
  MPI_Bcast(logged.data(), static_cast<int>(logged.size()), MPI_CHAR, 0, MPI_COMM_WORLD);

  PrecomputeReport report;
  report.rays_mirrored = n_active * n_directions - mirrored.n_solved();
  const auto is_solved = [&](std::int64_t a, std::int64_t d) {
    return mirrored.is_solved(static_cast<std::int32_t>(a), static_cast<std::int32_t>(d));
  };
  for (std::int64_t ray = 0; ray < n_active * n_directions; ++ray)
    report.rays_resumed +=
        logged[static_cast<std::size_t>(ray)] && is_solved(ray / n_directions, ray % n_directions);
  if (complete) report.rays_resumed = mirrored.n_solved();
  std::int64_t solved = 0;
  int interrupted = 0;
  std::exception_ptr trouble;
  if (!complete) {
    WorkCounter counter(MPI_COMM_WORLD);
    try {
      DatabaseWriter log(file, header, session.rank());
      const Points normals = node_normals(mesh);
      for (std::int64_t a = counter.next(); a < n_active && !interrupted; a = counter.next()) {
        const auto node = sets.active[static_cast<std::size_t>(a)];
        bool touched = false;
        for (std::int64_t d = 0; d < n_directions && !interrupted; ++d) {
          if (logged[static_cast<std::size_t>(a * n_directions + d)] || !is_solved(a, d)) continue;
          if (!touched) probe_solver->touch({node});
          touched = true;
          const auto& e = header.directions[static_cast<std::size_t>(d)];
          const double inward =
              -(normals(node, 0) * e[0] + normals(node, 1) * e[1] + normals(node, 2) * e[2]);
          const bool requested = scene.probe.directions != Directions::hemisphere || inward > -1e-9;
          log.append(solve_ray(*probe_solver, header, static_cast<std::int32_t>(a),
                               static_cast<std::int32_t>(d), requested));
          ++solved;
          const auto done = counter.add_done(1) + 1 + report.rays_resumed;
          if (progress && session.rank() == 0) progress(done, mirrored.n_solved());
          if (stop && stop()) interrupted = 1;
        }
      }
      log.close();
    } catch (...) {
      trouble = std::current_exception();
    }
  }

  session.together([&] {
    if (!trouble) return;
    try {
      std::rethrow_exception(trouble);
    } catch (const Error& error) {
      throw Error(error.kind(), std::string(error.what()) + " (finished rays are kept: go on with --resume)",
                  "", "");
    }
  });
  MPI_Allreduce(MPI_IN_PLACE, &interrupted, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  session.together([&] {
    if (!interrupted && !complete && session.rank() == 0) DatabaseWriter::pack(file, header);
  });

  report.interrupted = interrupted != 0;
  report.core_seconds = cpu_seconds() - cpu_start;
  report.rays = solved;
  MPI_Allreduce(MPI_IN_PLACE, &report.core_seconds, 1, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &report.rays, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  if (!interrupted && session.rank() == 0) {
    const auto database = Database::open(file);
    const auto summary = summarize(database);
    for (const auto& [status, count] : summary.states) {
      if (status != Status::not_requested) report.increments += count;
      if (static_cast<int>(status) < 0) report.failed += count;
    }
    report.iterations = summary.newton_iterations;
    const auto statuses = database.statuses();
    const auto n_increments = static_cast<std::int64_t>(header.magnitudes_m.size());
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(statuses.size()); ++i) {
      const auto ray = i / n_increments;
      report.increments_solved += statuses[static_cast<std::size_t>(i)] != Status::not_requested &&
                                  is_solved(ray / n_directions, ray % n_directions);
    }
  }
  report.wall_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
