#include <algorithm>
#include <cassert>
#include <numeric>
#include <phynness/planning/schedule.hpp>
#include <queue>
#include <utility>

namespace phynness {

double RayWork::total_seconds() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }
double RayWork::longest_seconds() const {
  return seconds.empty() ? 0 : *std::max_element(seconds.begin(), seconds.end());
}

namespace {

/// Serves one request at a time, in the order of arrival.
class Server {
 public:
  double serve(double arrival, double service) { return _free = std::max(arrival, _free) + service; }

 private:
  double _free = 0;
};

struct Rank {
  std::int64_t next = 0, end = 0;  ///< remaining rays of the present task
  std::int32_t node = -1;
};

enum class Moment { wants_ray, solved };
struct Event {
  double time;
  int rank;
  Moment moment;
  bool operator<(const Event& other) const {  // the earliest event is on top
    if (time != other.time) return time > other.time;
    return rank > other.rank;
  }
};

class Simulation {
 public:
  Simulation(const RayWork& work, const MachineCosts& machine, int ranks)
      : _work(work), _machine(machine), _starts(ray_tasks(work.rays, ranks)), _ranks(static_cast<std::size_t>(ranks)) {
    _schedule.ranks = ranks;
  }

  Schedule run() {
    Server metadata;
    for (int r = 0; r < _schedule.ranks; ++r) {
      const double ready = metadata.serve(_machine.launch_s + _machine.start_s, _machine.log_create_s);
      _schedule.spent.start += ready;
      _events.push({ready, r, Moment::wants_ray});
    }
    while (!_events.empty()) {
      const Event event = _events.top();
      _events.pop();
      event.moment == Moment::solved ? log(event) : take_ray(event);
    }
    for (const double time : _ends) _schedule.solved_s = std::max(_schedule.solved_s, time);
    for (const double time : _ends) _schedule.spent.tail += _schedule.solved_s - time;
    const double packing =
        _schedule.ranks * _machine.pack_log_open_s + static_cast<double>(_work.n_rays()) * _machine.pack_s_per_ray;
    _schedule.spent.packing = packing * _schedule.ranks;
    _schedule.wall_s = _schedule.solved_s + packing;
    return std::move(_schedule);
  }

 private:
  void log(const Event& event) {
    const double now =
        _disk.serve(event.time + _machine.log_s_per_ray, _work.bytes_per_ray / _machine.bandwidth_B_per_s);
    _schedule.spent.writing += now - event.time;
    _events.push({now, event.rank, Moment::wants_ray});
  }

  void take_ray(const Event& event) {
    Rank& rank = _ranks[static_cast<std::size_t>(event.rank)];
    double now = event.time;
    if (rank.next == rank.end) {
      now = _counter.serve(now + _machine.fetch_latency_s / 2, _machine.fetch_service_s) + _machine.fetch_latency_s / 2;
      _schedule.spent.fetching += now - event.time;
      const std::size_t task = _schedule.tasks.size();
      if (task + 1 >= _starts.size()) {
        _ends.push_back(now);
        return;
      }
      _schedule.tasks.push_back({_starts[task], _starts[task + 1], event.rank});
      rank.next = _starts[task];
      rank.end = _starts[task + 1];
    }
    const auto ray = static_cast<std::size_t>(rank.next++);
    // A ray that is not requested needs no preparation of its node.
    if (_work.seconds[ray] > 0 && _work.rays[ray].active != rank.node) {
      rank.node = _work.rays[ray].active;
      now += _machine.node_setup_s;
      _schedule.spent.node_setup += _machine.node_setup_s;
    }
    _schedule.spent.solving += _work.seconds[ray];
    _events.push({now + _work.seconds[ray], event.rank, Moment::solved});
  }

  const RayWork& _work;
  const MachineCosts& _machine;
  const std::vector<std::int64_t> _starts;  ///< of tasks
  std::vector<Rank> _ranks;
  std::vector<double> _ends;  ///< of ranks that found no task
  std::priority_queue<Event> _events;
  Server _counter, _disk;
  Schedule _schedule;
};

}  // namespace

Schedule simulate(const RayWork& work, const MachineCosts& machine, int ranks) {
  assert(ranks >= 1 && machine.bandwidth_B_per_s > 0 && work.seconds.size() == work.rays.size());
  return Simulation(work, machine, ranks).run();
}

}  // namespace phynness
