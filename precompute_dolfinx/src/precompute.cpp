#include <mpi.h>
#include <sys/resource.h>

#include <chrono>
#include <numeric>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/formats/ray_tasks.hpp>
#include <phynness/formats/version.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <span>

#include "solve_ray.hpp"
#include "solver_log.hpp"
#include "work_counter.hpp"

namespace phynness {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// Measures the CPU time of work without waiting for other ranks, which in MPI also consumes CPU time.
class WorkClock {
 public:
  void start() { _start = cpu_seconds(); }
  void stop() { _seconds += cpu_seconds() - _start; }
  double seconds() const { return _seconds; }

 private:
  double _start = 0, _seconds = 0;
};

void add(std::span<const Status> statuses, std::span<const std::int32_t> iterations, RayCounts& sum) {
  ++sum.rays;
  sum.rays_solved += !statuses.empty() && statuses.front() != Status::not_requested;
  for (const auto status : statuses) {
    const bool is_tried = status != Status::not_requested && status != Status::after_end;
    sum.increments += is_tried;
    sum.after_end += status == Status::after_end;
    sum.failed += static_cast<int>(status) < 0;
    sum.library_errors += status == Status::library_error;
  }
  sum.iterations = std::accumulate(iterations.begin(), iterations.end(), sum.iterations);
}

RayCounts of_all_ranks(RayCounts counts) {
  MPI_Allreduce(MPI_IN_PLACE, &counts, sizeof counts / sizeof counts.rays, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  return counts;
}

/// Figures of one rank.
struct Share {
  RayCounts counts;
  std::int64_t tasks = 0;
  double busy_seconds = 0;
  bool interrupted = false;
};

/// Solves rays node by node.
class RaysOfNodes {
 public:
  RaysOfNodes(ProbeSolver& solver, const DatabaseHeader& header) : _solver(solver), _header(header) {}

  Ray solve(const RayIndex& ray) {
    const auto node = _header.sets.active[static_cast<std::size_t>(ray.active)];
    SolverLog::instance().set_context("node " + std::to_string(node) + ", direction " + std::to_string(ray.direction));
    if (!touch(ray.active, node)) return failed_ray(_header, ray.active, ray.direction);
    return solve_ray(_solver, _header, ray.active, ray.direction);
  }

 private:
  /// @return false if the node could not be prepared; the next ray tries again
  bool touch(std::int32_t active, std::int32_t node) {
    if (_touched == active) return true;
    _touched = -1;
    try {
      _solver.touch({node});
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      const auto* known = dynamic_cast<const Error*>(&error);
      if (known && known->kind() == Error::Kind::input) throw;
      SolverLog::instance().write(error.what());
      recover(_solver);
      return false;
    }
    _touched = active;
    return true;
  }

  ProbeSolver& _solver;
  const DatabaseHeader& _header;
  std::int32_t _touched = -1;
};

/// Logs rays in the order in which they were solved. Rays that could not be started are held back until a later ray
/// starts. Otherwise a rank that cannot start any ray, for example because its machine is out of memory, would record
/// all remaining rays as failed. Rays that are never logged are solved with --resume.
class RayLog {
 public:
  explicit RayLog(DatabaseWriter& log) : _log(log) {}

  /// @throws Error (failure) if too many rays in succession cannot be started
  void append(Ray ray, Share& share) {
    constexpr std::size_t most_held_back = 20;
    const bool began = ray.status.empty() || ray.status.front() != Status::library_error;
    _held_back.push_back(std::move(ray));
    if (began) return flush(share);
    if (_held_back.size() >= most_held_back)
      throw failure(std::to_string(most_held_back) + " rays in succession could not be started",
                    SolverLog::instance().last(),
                    "remove the cause and continue with --resume; these rays are not recorded");
  }
  void flush(Share& share) {
    for (const auto& ray : _held_back) {
      _log.append(ray);
      add(ray.status, ray.iterations, share.counts);
    }
    _held_back.clear();
  }

 private:
  DatabaseWriter& _log;
  std::vector<Ray> _held_back;
};

/// Fetches and solves tasks until none is left or `stop` returns true.
/// @param done  called after every ray
void solve_tasks(ProbeSolver& solver, DatabaseWriter& log, const DatabaseHeader& header,
                 const std::vector<RayIndex>& rays, WorkCounter& counter, int n_ranks,
                 const std::function<void()>& done, const std::function<bool()>& stop, Share& share) {
  const auto tasks = ray_tasks(rays, n_ranks);
  const auto n_tasks = static_cast<std::int64_t>(tasks.size()) - 1;
  RaysOfNodes nodes(solver, header);
  RayLog ray_log(log);
  solver.set_stop([&] {
    counter.serve();
    return stop && stop();
  });
  for (auto task = counter.next(); task < n_tasks; task = counter.next()) {
    const auto start = Clock::now();
    ++share.tasks;
    for (auto i = tasks[static_cast<std::size_t>(task)]; i < tasks[static_cast<std::size_t>(task) + 1]; ++i) {
      try {
        ray_log.append(nodes.solve(rays[static_cast<std::size_t>(i)]), share);
      } catch (const Interrupted&) {
        share.interrupted = true;
        break;
      }
      share.interrupted = stop && stop();
      done();
      if (share.interrupted) break;
    }
    share.busy_seconds += seconds_since(start);
    if (share.interrupted) break;
  }
  solver.set_stop({});
  SolverLog::instance().set_context("");
  if (!share.interrupted) ray_log.flush(share);
}

/// Logs the rays that are not requested.
void log_not_requested(const std::filesystem::path& file, const DatabaseHeader& header,
                       const std::vector<RayIndex>& rays, Share& share) {
  if (rays.empty()) return;
  DatabaseWriter log(file, header, 0);
  for (const auto& [active, direction] : rays) {
    const auto ray = empty_ray(header, active, direction);
    log.append(ray);
    add(ray.status, ray.iterations, share.counts);
  }
  log.close();
}

/// Throws the error of this rank with the note that finished rays are kept. @throws Error if `trouble` is set
void rethrow(const std::exception_ptr& trouble) {
  if (!trouble) return;
  try {
    std::rethrow_exception(trouble);
  } catch (const Error& error) {
    const std::string text = error.what();
    const bool says_so = text.find("--resume") != std::string::npos;
    throw Error(error.kind(), text + (says_so ? "" : " (finished rays are kept; continue with --resume)"), "", "");
  }
}

bool on_any_rank(bool here) {
  int any = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return any != 0;
}

/// Sets the figures of all ranks.
void add_up(const SolverSession& session, const Share& share, double core_seconds, PrecomputeReport& report) {
  static_cast<RayCounts&>(report) = of_all_ranks(share.counts);
  report.increments_of_run = report.increments;
  report.after_end = 0;
  report.core_seconds = session.sum(core_seconds);
  const auto figures =
      session.gather({static_cast<double>(share.counts.rays), static_cast<double>(share.tasks), share.busy_seconds,
                      report.solve_seconds - share.busy_seconds, core_seconds, peak_memory_bytes()});
  for (std::size_t i = 0; i + 5 < figures.size(); i += 6)
    report.ranks.push_back({static_cast<std::int64_t>(figures[i]), static_cast<std::int64_t>(figures[i + 1]),
                            figures[i + 2], figures[i + 3], figures[i + 4], figures[i + 5]});
}

/// Of a file that this run has not packed.
RayCounts count_finished(const std::filesystem::path& file) {
  const auto database = Database::open(file);
  const auto statuses = database.statuses();
  std::vector<std::int32_t> iterations(statuses.size());
  database.read("iterations", 0, database.header().sets.active.size(), iterations.data());
  const auto n = database.header().magnitudes_m.size();
  RayCounts finished;
  for (std::size_t ray = 0; ray * n < statuses.size(); ++ray)
    add({&statuses[ray * n], n}, {&iterations[ray * n], n}, finished);
  return finished;
}

/// Sets the figures of the whole database. @param finished  what this rank has packed
void add_up(const RayCounts& finished, PrecomputeReport& report) {
  const RayCounts all = of_all_ranks(finished);
  report.increments = all.increments;
  report.after_end = all.after_end;
  report.failed = all.failed;
  report.iterations = all.iterations;
}

/// The numbers of all ranks, one after another, on all.
std::vector<std::int64_t> gathered(const std::vector<std::int64_t>& own, int n_ranks) {
  const int n = static_cast<int>(own.size());
  std::vector<int> counts(static_cast<std::size_t>(n_ranks)), offsets(counts.size());
  MPI_Allgather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<std::int64_t> all(static_cast<std::size_t>(offsets.back() + counts.back()));
  MPI_Allgatherv(own.data(), n, MPI_INT64_T, all.data(), counts.data(), offsets.data(), MPI_INT64_T, MPI_COMM_WORLD);
  return all;
}

/// Flags, n_active x n_directions, of the rays that the scene wants and that are not logged.
std::vector<char> missing_rays(const Scene& scene, const Mesh& mesh, const DatabaseHeader& header,
                               const std::vector<char>& logged) {
  const auto requested = requested_rays(scene, mesh, header);
  std::vector<char> missing(logged.size(), 0);
  for (const auto& [active, direction] : rays_left(header, logged)) {
    const auto ray = static_cast<std::size_t>(active) * header.directions.size() + static_cast<std::size_t>(direction);
    missing[ray] = requested[ray];
  }
  return missing;
}

std::string what(const std::exception_ptr& trouble) {
  try {
    std::rethrow_exception(trouble);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an error without a message";
  }
}

/// Runs the work of a rank. An exception is returned after the other ranks have been told to fetch no further tasks.
std::exception_ptr guarded(WorkCounter& counter, int rank, const std::function<void(const std::string&)>& warn,
                           const std::function<void()>& work) {
  try {
    work();
    return nullptr;
  } catch (...) {
    const auto trouble = std::current_exception();
    counter.abandon();
    if (warn) warn("rank " + std::to_string(rank) + " stops: " + what(trouble));
    return trouble;
  }
}

}  // namespace

PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                            const PrecomputeTarget& target, const PrecomputeProgress& progress,
                            const std::function<bool()>& stop, const std::function<void(const std::string&)>& warn) {
  const auto start = Clock::now();
  WorkClock core;
  core.start();
  auto header = database_header(scene, mesh, sets);
  header.shard = target.shard;
  const auto log_file = target.file.string() + ".solver.log";
  SolverLog::instance().open(log_file, session.rank());

  RayCounts finished;  // what this rank has packed, including rays of earlier runs
  const PackingRanks ranks{session.rank(), session.size(),
                           [&](const auto& work) {
                             session.together([&] {
                               core.start();
                               work();
                               core.stop();
                             });
                           },
                           [&](const auto& own) { return gathered(own, session.size()); },
                           [&](const Ray& ray) { add(ray.status, ray.iterations, finished); }};
  std::vector<char> logged(header.sets.active.size() * header.directions.size(), 0);
  const auto rays_in_all = static_cast<std::int64_t>(rays_left(header, logged).size());
  std::int64_t taken = 0;
  int complete = 0;
  std::optional<ProbeSolver> probe_solver;
  session.together([&] {
    // Created before the file, so that a scene that cannot be solved leaves no file.
    probe_solver.emplace(scene, mesh, sets);
    if (session.rank() == 0) {
      DatabaseWriter::create(target.file, header, target.resume);
      std::error_code none;
      if (!target.resume) std::filesystem::remove(log_file, none);  // of the database that was there before
      complete = Database::is_complete(target.file) ? 1 : 0;
    }
    core.stop();
  });
  MPI_Bcast(&complete, 1, MPI_INT, 0, MPI_COMM_WORLD);
  logged = DatabaseWriter::logged(target.file, header, ranks);
  if (!target.from.empty() && !complete)
    ranks.together([&] {
      taken = DatabaseWriter::take(target.file, header, target.from, missing_rays(scene, mesh, header, logged),
                                   session.rank(), session.size());
    });
  taken = static_cast<std::int64_t>(session.sum(static_cast<double>(taken)));
  if (taken > 0) logged = DatabaseWriter::logged(target.file, header, ranks);

  PrecomputeReport report;
  report.rays_taken = taken;
  report.rays_resumed = rays_in_all - std::ssize(rays_left(header, logged)) - taken;
  report.setup_seconds = seconds_since(start);
  const auto solve_start = Clock::now();
  Share share;
  const auto left = [&] { return rays_left(header, logged); };
  const auto missing = missing_rays(scene, mesh, header, logged);
  std::vector<RayIndex> rays;
  for (const auto& ray : left())
    if (missing[static_cast<std::size_t>(ray.active) * header.directions.size() +
                static_cast<std::size_t>(ray.direction)])
      rays.push_back(ray);
  if (!rays.empty()) {
    WorkCounter counter(MPI_COMM_WORLD);
    core.start();
    const auto done = [&] {
      counter.add_done(1);
      if (progress && session.rank() == 0)
        progress(report.rays_found() + counter.done(), report.rays_found() + std::ssize(rays));
    };
    const auto trouble = guarded(counter, session.rank(), warn, [&] {
      DatabaseWriter log(target.file, header, session.rank());
      solve_tasks(*probe_solver, log, header, rays, counter, session.size(), done, stop, share);
      log.close();
    });
    core.stop();
    session.together([&] { rethrow(trouble); });
    report.interrupted = on_any_rank(share.interrupted);
  }
  for (const auto& [active, direction] : rays)
    logged[static_cast<std::size_t>(active) * header.directions.size() + static_cast<std::size_t>(direction)] = 1;
  session.together([&] {
    if (!report.interrupted && session.rank() == 0) log_not_requested(target.file, header, left(), share);
  });
  report.solve_seconds = seconds_since(solve_start);
  const bool packs = !report.interrupted && !complete && !target.shard;
  const auto pack_start = Clock::now();
  if (packs) DatabaseWriter::pack(target.file, header, ranks);
  report.pack_seconds = seconds_since(pack_start);

  add_up(session, share, core.seconds(), report);
  if (complete && session.rank() == 0) finished = count_finished(target.file);
  if (packs || complete) add_up(finished, report);
  report.wall_seconds = seconds_since(start);
  return report;
}

}  // namespace phynness
