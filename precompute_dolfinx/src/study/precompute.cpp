#include <mpi.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <numeric>
#include <optional>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>

#include "solve_ray.hpp"
#include "solve_tasks.hpp"
#include "solver_log.hpp"

namespace phynness {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Measures CPU time without the waiting for other ranks, which in MPI also consumes CPU time.
class WorkClock {
 public:
  void start() { _start = cpu_seconds(); }
  void stop() { _seconds += cpu_seconds() - _start; }
  double seconds() const { return _seconds; }

 private:
  double _start = 0, _seconds = 0;
};

RayCounts of_all_ranks(RayCounts counts) {
  MPI_Allreduce(MPI_IN_PLACE, &counts, sizeof counts / sizeof counts.rays, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  return counts;
}

/// Throws the error of this rank with the note that finished rays are kept. @throws Error if `exception` is set
void rethrow(const std::exception_ptr& exception) {
  if (!exception) return;
  try {
    std::rethrow_exception(exception);
  } catch (const Error& error) {
    const std::string text = error.what();
    const bool mentions_resume = text.find("--resume") != std::string::npos;
    throw Error(error.kind(), text + (mentions_resume ? "" : " (finished rays are kept; continue with --resume)"), "",
                "");
  }
}

bool on_any_rank(bool here) {
  int any = here ? 1 : 0;
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return any != 0;
}

/// Sets the sums over all ranks.
void sum_totals(const SolverSession& session, const RankTotals& totals, double core_seconds, PrecomputeReport& report) {
  static_cast<RayCounts&>(report) = of_all_ranks(totals.counts);
  report.increments_of_run = report.increments;
  report.after_end = 0;
  report.core_seconds = session.sum(core_seconds);
  const double busy = session.sum(totals.busy_seconds), all = session.sum(report.solve_seconds);
  report.idle_share = report.rays > 0 ? 1 - busy / all : 0;
  for (const double bytes : session.gather(std::vector{peak_memory_bytes()}))
    report.peak_memory_bytes = std::max(report.peak_memory_bytes, bytes);
}

/// Counts the rays of a database that an earlier run has packed.
RayCounts count_finished(const std::filesystem::path& file) {
  const auto database = Database::open(file);
  RayCounts finished;
  for (std::int32_t node = 0; node < static_cast<std::int32_t>(database.header().sets.active.size()); ++node)
    for (const Ray& ray : database.rays(node)) count(ray.status, ray.iterations, finished);
  return finished;
}

/// Sets the figures of the whole database. @param finished  what this rank has packed
void sum_packed(const RayCounts& finished, PrecomputeReport& report) {
  const RayCounts all = of_all_ranks(finished);
  report.increments = all.increments;
  report.after_end = all.after_end;
  report.failed = all.failed;
  report.iterations = all.iterations;
}

/// Concatenates the numbers of all ranks on all ranks.
std::vector<std::int64_t> gathered(const std::vector<std::int64_t>& own, int n_ranks) {
  const int n = static_cast<int>(own.size());
  std::vector<int> counts(static_cast<std::size_t>(n_ranks)), offsets(counts.size());
  MPI_Allgather(&n, 1, MPI_INT, counts.data(), 1, MPI_INT, MPI_COMM_WORLD);
  std::exclusive_scan(counts.begin(), counts.end(), offsets.begin(), 0);
  std::vector<std::int64_t> all(static_cast<std::size_t>(offsets.back() + counts.back()));
  MPI_Allgatherv(own.data(), n, MPI_INT64_T, all.data(), counts.data(), offsets.data(), MPI_INT64_T, MPI_COMM_WORLD);
  return all;
}

/// The parts of precompute() and their shared data. All ranks call each part.
class Run {
 public:
  Run(const SolverSession& session, const Scene& scene, const Mesh& mesh, const NodeSets& sets,
      const PrecomputeTarget& target)
      : _session(session),
        _target(target),
        _header(database_header(scene, mesh, sets)),
        _requested(requested_rays(scene, mesh, _header)) {
    _core.start();
    SolverLog::instance().open(solver_log(), session.rank());
    // Created before the file, so that a scene that cannot be solved leaves no file.
    session.together([&] { _solver.emplace(scene, mesh, sets); });
    _core.stop();
  }

  void create_file();
  /// Copies the rays of the database that this run extends.
  void copy_rays();
  void solve(const PrecomputeProgress& progress, const std::function<bool()>& stop,
             const std::function<void(const std::string&)>& warn);
  /// Rays that are not requested are recorded as such.
  void pack(const PrecomputeProgress& at_rest, const std::function<bool()>& stop);
  void sum_report();

  PrecomputeReport report;

 private:
  std::string solver_log() const { return _target.file.string() + ".solver.log"; }
  int log_number() const { return _session.rank() + (_target.part ? _target.part->index * _session.size() : 0); }
  /// Whether the ray belongs to this part.
  bool is_own(std::size_t ray) const {
    const auto n = _header.directions.size();
    return !_target.part ||
           static_cast<int>((ray / n + ray % n) % static_cast<std::size_t>(_target.part->count)) == _target.part->index;
  }
  /// Flags, n_active x n_directions, of the rays of this part that are requested and not logged.
  std::vector<char> missing() const {
    std::vector<char> flags(_logged.size());
    for (std::size_t ray = 0; ray < flags.size(); ++ray) flags[ray] = _requested[ray] && !_logged[ray] && is_own(ray);
    return flags;
  }
  std::int64_t own_logged() const {
    std::int64_t n = 0;
    for (std::size_t ray = 0; ray < _logged.size(); ++ray) n += _logged[ray] && is_own(ray);
    return n;
  }

  const SolverSession& _session;
  const PrecomputeTarget& _target;
  DatabaseHeader _header;
  std::vector<char> _requested, _logged;
  WorkClock _core;
  std::optional<ProbeSolver> _solver;
  RankTotals _totals;
  RayCounts _packed;  ///< counts of the rays that this rank has packed
  bool _complete = false;
  PackingRanks _ranks{_session.rank(),
                      _session.size(),
                      [this](const auto& work) {
                        _session.together([&] {
                          _core.start();
                          work();
                          _core.stop();
                        });
                      },
                      [this](const auto& own) { return gathered(own, _session.size()); },
                      [this](const auto& own) { return _session.gather(own); },
                      [this](const Ray& ray) { count(ray.status, ray.iterations, _packed); }};
};

void Run::create_file() {
  _ranks.together([&] {
    if (_session.rank() != 0) return;
    DatabaseWriter::create(_target.file, _header, _target.resume, _target.part ? _target.part->index : 0);
    std::error_code none;
    if (!_target.resume) std::filesystem::remove(solver_log(), none);  // the log of a replaced database
    _complete = Database::is_complete(_target.file);
  });
  _complete = on_any_rank(_complete);
  _logged = DatabaseWriter::logged(_target.file, _header, _ranks);
  report.rays_resumed = own_logged();
}

void Run::copy_rays() {
  if (_target.from.empty() || _complete) return;
  std::int64_t copied = 0;
  _ranks.together([&] {
    copied = DatabaseWriter::take(_target.file, _header, _target.from, missing(), log_number(), _session.rank(),
                                  _session.size());
  });
  report.rays_taken = _session.total(copied);
  if (report.rays_taken > 0) _logged = DatabaseWriter::logged(_target.file, _header, _ranks);
}

void Run::solve(const PrecomputeProgress& progress, const std::function<bool()>& stop,
                const std::function<void(const std::string&)>& warn) {
  auto solved = missing();
  for (char& flag : solved) flag = !flag;
  const auto rays = remaining_rays(_header, solved);
  if (rays.empty()) return;
  WorkCounter counter(MPI_COMM_WORLD);
  _core.start();
  const auto done = [&] {
    counter.add_done(1);
    if (progress && _session.rank() == 0)
      progress(report.rays_found() + counter.done(), report.rays_found() + std::ssize(rays));
  };
  const auto exception = run_guarded(counter, _session.rank(), warn, [&] {
    DatabaseWriter log(_target.file, _header, log_number());
    solve_tasks(*_solver, log, _header, rays, counter, _session.size(), done, stop, _totals);
    log.close();
  });
  _core.stop();
  _session.together([&] { rethrow(exception); });
  report.interrupted = on_any_rank(_totals.interrupted);
}

void Run::pack(const PrecomputeProgress& at_rest, const std::function<bool()>& stop) {
  if (report.interrupted || _complete || _target.part) return;
  _ranks.together([&] {
    if (_session.rank() != 0) return;
    std::optional<DatabaseWriter> log;
    for (std::size_t i = 0; i < _logged.size(); ++i) {
      if (_requested[i] || _logged[i]) continue;
      if (!log) log.emplace(_target.file, _header, log_number());
      const auto n = _header.directions.size();
      const auto ray = empty_ray(_header, static_cast<std::int32_t>(i / n), static_cast<std::int32_t>(i % n));
      log->append(ray);
      count(ray.status, ray.iterations, _totals.counts);
    }
    if (log) log->close();
  });
  bool is_interrupted = false;
  try {
    DatabaseWriter::pack(_target.file, _header, _ranks, [&](std::int32_t point) {
      is_interrupted = stop && stop();
      if (is_interrupted) throw Interrupted();
      const auto start = Clock::now();
      auto response = response_at_rest(*_solver, _header, point);
      report.at_rest_seconds += seconds_since(start);
      if (at_rest) at_rest(point + 1, std::ssize(_header.sets.linear));
      return response;
    });
  } catch (...) {
    report.interrupted = on_any_rank(is_interrupted);
    if (!report.interrupted) throw;
  }
}

void Run::sum_report() {
  sum_totals(_session, _totals, _core.seconds(), report);
  if (_complete && _session.rank() == 0) _packed = count_finished(_target.file);
  if (_complete || !(report.interrupted || _target.part)) sum_packed(_packed, report);
}

}  // namespace

double peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

PrecomputeReport precompute(const SolverSession& session, const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                            const PrecomputeTarget& target, const PrecomputeProgress& progress,
                            const std::function<bool()>& stop, const std::function<void(const std::string&)>& warn,
                            const PrecomputeProgress& at_rest) {
  const auto start = Clock::now();
  Run run(session, scene, mesh, sets, target);
  run.create_file();
  run.copy_rays();
  const auto solving = Clock::now();
  run.solve(progress, stop, warn);
  const auto packing = Clock::now();
  run.pack(at_rest, stop);
  const auto end = Clock::now();
  const auto seconds = [](auto from, auto to) { return std::chrono::duration<double>(to - from).count(); };
  run.report.setup_seconds = seconds(start, solving);
  run.report.solve_seconds = seconds(solving, packing);
  run.report.pack_seconds = seconds(packing, end);
  run.sum_report();
  run.report.wall_seconds = seconds_since(start);
  return run.report;
}

}  // namespace phynness
