#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <phynness/planning/schedule.hpp>
#include <queue>

namespace phynness {

double RayWork::ray_seconds(std::size_t ray) const {
  const auto first =
      seconds.begin() + static_cast<std::ptrdiff_t>(ray * static_cast<std::size_t>(increments));
  return std::accumulate(first, first + increments, 0.0);
}
double RayWork::total_seconds() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }

namespace {

/// Serves one request at a time, in the order of arrival.
class Server {
 public:
  double serve(double arrival, double service) { return _free = std::max(arrival, _free) + service; }

 private:
  double _free = 0;
};

/// The stretch of a ray that a rank solves without asking again.
struct Piece {
  std::size_t ray = 0;
  int first = 0, last = 0;  ///< increments [first, last)
};

/// Hands out pieces. An empty answer: nothing now.
class Dispatcher {
 public:
  Dispatcher(const RayWork& work, const Policy& policy, int ranks)
      : _work(work), _policy(policy), _ranks(ranks), _order(work.n_rays()) {
    std::iota(_order.begin(), _order.end(), std::size_t{0});
    if (policy.order == Order::longest_first) order_longest_first();
    if (policy.grain == Grain::increment)
      for (std::size_t place = 0; place < _order.size(); ++place) release(_order[place], 0);
  }

  std::vector<Piece> next() {
    if (_policy.grain == Grain::increment) return next_increment();
    std::vector<Piece> pieces;
    const std::size_t count = chunk();
    for (std::size_t i = 0; i < count; ++i) pieces.push_back({_order[_given + i], 0, _work.increments});
    _given += count;
    return pieces;
  }

  /// True if the piece left a rest of its ray behind, for anyone to take.
  bool finished(const Piece& piece) {
    if (piece.last == _work.increments) return false;
    release(piece.ray, piece.last);
    return true;
  }

 private:
  struct Ready {
    double remaining_s;
    std::size_t place;  ///< ties: first come
    Piece piece;
    bool operator<(const Ready& other) const {
      return remaining_s != other.remaining_s ? remaining_s < other.remaining_s : place > other.place;
    }
  };

  void order_longest_first() {
    // Tasks are whole nodes, if they are the grain; rays else.
    std::vector<double> cost(_order.size());
    for (std::size_t r = 0; r < cost.size(); ++r) cost[r] = _work.ray_seconds(r);
    if (_policy.grain == Grain::node)
      for (std::size_t first = 0; first < cost.size();) {
        const std::size_t last = end_of_node(first);
        const double sum = std::accumulate(cost.begin() + static_cast<std::ptrdiff_t>(first),
                                           cost.begin() + static_cast<std::ptrdiff_t>(last), 0.0);
        for (; first < last; ++first) cost[first] = sum;
      }
    std::stable_sort(_order.begin(), _order.end(), [&](std::size_t a, std::size_t b) {
      if (cost[a] != cost[b]) return cost[a] > cost[b];
      return _work.node[a] < _work.node[b];
    });
  }

  std::size_t end_of_node(std::size_t place) const {
    std::size_t end = place + 1;
    while (end < _order.size() && _work.node[_order[end]] == _work.node[_order[place]]) ++end;
    return end;
  }

  std::size_t chunk() const {
    const std::size_t left = _order.size() - _given;
    if (left == 0) return 0;
    if (_policy.grain == Grain::node) return end_of_node(_given) - _given;
    std::size_t count = 1;
    if (_policy.guided_divisor > 0)
      count =
          static_cast<std::size_t>(std::ceil(static_cast<double>(left) / (_policy.guided_divisor * _ranks)));
    if (_policy.one_node) count = std::min(count, end_of_node(_given) - _given);
    return std::min(count, left);
  }

  void release(std::size_t ray, int first) {
    double remaining_s = 0;
    for (int i = first; i < _work.increments; ++i)
      remaining_s +=
          _work.seconds[ray * static_cast<std::size_t>(_work.increments) + static_cast<std::size_t>(i)];
    if (_policy.order == Order::stored) remaining_s = 0;
    _ready.push({remaining_s, _released++, {ray, first, first + 1}});
  }
  std::vector<Piece> next_increment() {
    if (_ready.empty()) return {};
    const Piece piece = _ready.top().piece;
    _ready.pop();
    return {piece};
  }

  const RayWork& _work;
  Policy _policy;
  int _ranks;
  std::vector<std::size_t> _order;
  std::size_t _given = 0, _released = 0;
  std::priority_queue<Ready> _ready;
};

struct Rank {
  std::vector<Piece> pieces;  ///< of the chunk in hand
  std::size_t next = 0;
  std::int32_t node = -1;
};

enum class Moment { wants_task, solved };
struct Event {
  double time;
  int rank;
  Moment moment;
  bool operator<(const Event& other) const {  // the earliest is on top
    if (time != other.time) return time > other.time;
    return rank > other.rank;
  }
};

}  // namespace

Schedule simulate(const RayWork& work, const MachineCosts& machine, const Policy& policy, int ranks) {
  assert(ranks >= 1 && machine.bandwidth_B_per_s > 0);
  Schedule schedule;
  schedule.ranks = ranks;
  auto& spent = schedule.spent;
  Dispatcher dispatcher(work, policy, ranks);
  Server counter, metadata, disk;
  std::vector<Rank> all(static_cast<std::size_t>(ranks));
  std::priority_queue<Event> events;
  std::vector<Event> idle;  ///< nothing to do now; the rest of a ray may still come
  const double record_s = work.bytes_per_ray / machine.bandwidth_B_per_s;

  for (int r = 0; r < ranks; ++r) {
    const double ready = metadata.serve(machine.launch_s + machine.start_s, machine.log_create_s);
    spent.start += ready;
    events.push({ready, r, Moment::wants_task});
  }
  while (!events.empty()) {
    const Event event = events.top();
    events.pop();
    Rank& rank = all[static_cast<std::size_t>(event.rank)];
    double now = event.time;
    if (event.moment == Moment::solved) {
      const Piece done = rank.pieces[rank.next++];
      if (done.last == work.increments) {
        now = disk.serve(now, record_s);
        spent.writing += now - event.time;
      }
      events.push({now, event.rank, Moment::wants_task});
      if (dispatcher.finished(done) && !idle.empty()) {
        const Event waiting = idle.back();
        idle.pop_back();
        spent.tail += now - waiting.time;
        events.push({now, waiting.rank, Moment::wants_task});
      }
      continue;
    }
    if (rank.next == rank.pieces.size()) {
      now = counter.serve(now + machine.fetch_latency_s / 2, machine.fetch_service_s) +
            machine.fetch_latency_s / 2;
      spent.fetching += now - event.time;
      rank.pieces = dispatcher.next();
      rank.next = 0;
      if (rank.pieces.empty()) {
        idle.push_back({now, event.rank, Moment::wants_task});
        continue;
      }
    }
    const Piece& piece = rank.pieces[rank.next];
    if (work.node[piece.ray] != rank.node) {
      rank.node = work.node[piece.ray];
      now += machine.node_setup_s;
      spent.node_setup += machine.node_setup_s;
    }
    for (int i = piece.first; i < piece.last; ++i) {
      const double s =
          work.seconds[piece.ray * static_cast<std::size_t>(work.increments) + static_cast<std::size_t>(i)];
      now += s;
      spent.solving += s;
    }
    events.push({now, event.rank, Moment::solved});
  }
  for (const Event& e : idle) schedule.solved_s = std::max(schedule.solved_s, e.time);
  for (const Event& e : idle) spent.tail += schedule.solved_s - e.time;
  const double packing =
      ranks * machine.pack_log_open_s + static_cast<double>(work.n_rays()) * machine.pack_s_per_ray;
  spent.packing = packing * ranks;
  schedule.wall_s = schedule.solved_s + packing;
  return schedule;
}

}  // namespace phynness
