// The forces of many tools that do not act on each other, on all processors: the environments of a simulator for
// learning, each with one tool on an organ of its own. C++17 with threads.
//
//   phynness::Batch batch(phynness::Organ::read("out/demo/model"));
//   std::size_t n = x.size() / 3;                                     // x: points [m], n x 3
//   std::vector<phn_tool> tools(n);
//   std::vector<double> points(3 * n), distances(n), forces(3 * n);
//   std::vector<int> found(n), statuses(n);
//   if (!batch.nearest(x, tools, points, distances, found).ok()) return;
//   tools[0].displacement[2] = -0.01;                                 // and so on [m]
//   if (!batch.hold(tools, forces, statuses).ok()) return;            // statuses: of each tool
#ifndef PHYNNESS_BATCH_HPP
#define PHYNNESS_BATCH_HPP

#include <phynness/phynness.hpp>

#include <mutex>
#include <thread>

namespace phynness {

/// Answers each tool as Organ::hold and Organ::nearest of that tool alone, by the model. Each call starts and ends its
/// threads, so that a process with a Batch can be forked. Calls of several threads come one after the other.
class Batch {
 public:
  using Status = Organ::Status;

  /// @param organ  one with a model
  /// @param n_threads  0: as many as the machine has
  explicit Batch(const Organ& organ, unsigned n_threads = 0) : _status(organ.status()) {
    if (_status.ok() && organ.model() == nullptr) _status = PHN_ERROR_ARGUMENT;
    if (!_status.ok()) return;
    if (n_threads == 0) n_threads = (std::max)(1u, std::thread::hardware_concurrency());
    for (unsigned i = 0; i < n_threads; ++i) _organs.push_back(organ.another());
  }
  /// Of the construction. PHN_ERROR_ARGUMENT: there is no model.
  Status status() const noexcept { return _status; }

  /// @param forces    [N], tools.size() x 3; zeros where a tool is refused
  /// @param statuses  of each tool
  /// @return PHN_ERROR_BUFFER, with nothing written, if an output is too small; otherwise status(), also if
  ///         tools are refused
  Status hold(Span<const phn_tool> tools, Span<double> forces, Span<int> statuses) {
    if (forces.size() / 3 < tools.size() || statuses.size() < tools.size()) return PHN_ERROR_BUFFER;
    return for_each(tools.size(), [&](Organ& organ, std::size_t i) {
      double force[3];
      statuses[i] = organ.hold(tools[i], force);
      std::copy_n(force, 3, forces.data() + 3 * i);
    });
  }

  /// @param x         [m], tools.size() x 3
  /// @param tools     the places nearest to x, with displacement 0
  /// @param points    of these places, undeformed [m], tools.size() x 3
  /// @param distances from x [m], negative for an x inside
  /// @return as hold
  Status nearest(Span<const double> x, Span<phn_tool> tools, Span<double> points, Span<double> distances,
                 Span<int> statuses) {
    const std::size_t n = tools.size();
    if (x.size() / 3 < n || points.size() / 3 < n || distances.size() < n || statuses.size() < n)
      return PHN_ERROR_BUFFER;
    return for_each(n, [&](Organ& organ, std::size_t i) {
      double from[3], point[3];
      std::copy_n(x.data() + 3 * i, 3, from);
      statuses[i] = organ.nearest(from, tools[i], point, distances[i]);
      std::copy_n(point, 3, points.data() + 3 * i);
    });
  }

 private:
  /// Starting a thread takes as long as the forces of a few hundred tools.
  static constexpr std::size_t least_share = 512;

  template <class Answer>
  Status for_each(std::size_t n, const Answer& answer) {
    if (!_status.ok()) return _status;
    const std::lock_guard<std::mutex> one_call(_call);
    const std::size_t n_shares = (std::min)(_organs.size(), (std::max<std::size_t>)(1, n / least_share));
    const auto share = [&](std::size_t s) {
      for (std::size_t i = s * n / n_shares; i < (s + 1) * n / n_shares; ++i) answer(_organs[s], i);
    };
    std::vector<std::thread> threads;
    for (std::size_t s = 1; s < n_shares; ++s) threads.emplace_back(share, s);
    share(0);
    for (std::thread& thread : threads) thread.join();
    return _status;
  }

  Status _status;
  std::vector<Organ> _organs;
  std::mutex _call;
};

}  // namespace phynness

#endif
