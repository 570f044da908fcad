#include "solve_tasks.hpp"

#include <chrono>
#include <numeric>
#include <phynness/formats/error.hpp>

#include "solve_ray.hpp"
#include "solver_log.hpp"

namespace phynness {
namespace {

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

/// Logs rays in the order of their solution. Rays that could not be started are held back until a later ray starts.
/// Otherwise a rank that cannot start any ray, for example without memory, would record all remaining rays as failed.
class RayLog {
 public:
  explicit RayLog(DatabaseWriter& log) : _log(log) {}

  /// @throws Error (failure) if too many rays in succession cannot be started
  void append(Ray ray, RankTotals& totals) {
    constexpr std::size_t most_held_back = 20;
    const bool is_started = ray.status.empty() || ray.status.front() != Status::library_error;
    _held_back.push_back(std::move(ray));
    if (is_started) return flush(totals);
    if (_held_back.size() >= most_held_back)
      throw failure(std::to_string(most_held_back) + " rays in succession could not be started",
                    SolverLog::instance().last(),
                    "remove the cause and continue with --resume; these rays are not recorded");
  }
  void flush(RankTotals& totals) {
    for (const auto& ray : _held_back) {
      _log.append(ray);
      count(ray.status, ray.iterations, totals.counts);
    }
    _held_back.clear();
  }

 private:
  DatabaseWriter& _log;
  std::vector<Ray> _held_back;
};

std::string message_of(const std::exception_ptr& exception) {
  try {
    std::rethrow_exception(exception);
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an error without a message";
  }
}

}  // namespace

void count(std::span<const Status> statuses, std::span<const std::int32_t> iterations, RayCounts& sum) {
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

void solve_tasks(ProbeSolver& solver, DatabaseWriter& log, const DatabaseHeader& header,
                 const std::vector<RayIndex>& rays, WorkCounter& counter, int n_ranks,
                 const std::function<void()>& done, const std::function<bool()>& stop, RankTotals& totals) {
  const auto tasks = ray_tasks(rays, n_ranks);
  const auto n_tasks = static_cast<std::int64_t>(tasks.size()) - 1;
  RaysOfNodes nodes(solver, header);
  RayLog ray_log(log);
  solver.set_stop([&] {
    counter.make_progress();
    return stop && stop();
  });
  for (auto task = counter.next(); task < n_tasks; task = counter.next()) {
    const auto start = std::chrono::steady_clock::now();
    for (auto i = tasks[static_cast<std::size_t>(task)]; i < tasks[static_cast<std::size_t>(task) + 1]; ++i) {
      try {
        ray_log.append(nodes.solve(rays[static_cast<std::size_t>(i)]), totals);
      } catch (const Interrupted&) {
        totals.interrupted = true;
        break;
      }
      totals.interrupted = stop && stop();
      done();
      if (totals.interrupted) break;
    }
    totals.busy_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (totals.interrupted) break;
  }
  solver.set_stop({});
  SolverLog::instance().set_context("");
  if (!totals.interrupted) ray_log.flush(totals);
}

std::exception_ptr run_guarded(WorkCounter& counter, int rank, const std::function<void(const std::string&)>& warn,
                               const std::function<void()>& work) {
  try {
    work();
    return nullptr;
  } catch (...) {
    const auto exception = std::current_exception();
    counter.close();
    if (warn) warn("rank " + std::to_string(rank) + " stops: " + message_of(exception));
    return exception;
  }
}

}  // namespace phynness
