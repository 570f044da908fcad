// The comparison of a deeper study with a shallower one that it continues.
#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <phynness/formats/database.hpp>
#include <phynness/precompute/precompute.hpp>

namespace phynness {

/// The rays of a shallower database, with which those of a deeper one must begin.
class ShallowerRays {
 public:
  ShallowerRays(const std::filesystem::path& from, const DatabaseHeader& header) : _header(header) {
    if (from.empty()) return;
    _n_common = read_database_header(from).magnitudes_m.size();
    if (_n_common < header.magnitudes_m.size()) _database.emplace(Database::open(from, header));
  }
  void compare(const Ray& now) {
    if (!_database) return;
    if (_active != now.active) _rays = _database->rays(_active = now.active);
    const Ray& then = _rays.at(static_cast<std::size_t>(now.direction));
    if (!(then.seconds.front() > 0)) return;  // not there
    ++n_compared;
    for (std::size_t i = 0; i < _n_common; ++i) {
      if (then.status[i] == Status::library_error || now.status[i] == Status::library_error) return;
      const double difference = difference_at(then, now, i);
      if (difference <= most) continue;
      for (const double x : {double(now.active), double(now.direction), _header.magnitudes_m[i], difference})
        found.push_back(x);
      return;
    }
  }
  std::vector<OtherBranch> unpacked(const std::vector<double>& of_all_ranks) const {
    std::vector<OtherBranch> all;
    for (std::size_t i = 0; i + 3 < of_all_ranks.size(); i += 4)
      all.push_back({_header.sets.active[static_cast<std::size_t>(of_all_ranks[i])],
                     static_cast<std::int32_t>(of_all_ranks[i + 1]), of_all_ranks[i + 2], of_all_ranks[i + 3]});
    std::ranges::sort(all, {}, [](const auto& ray) { return std::pair{ray.node, ray.direction}; });
    return all;
  }

  std::int64_t n_compared = 0;
  std::vector<double> found;  ///< active node, direction, depth and difference of each

 private:
  /// Both are solved from rest along the same increments, so that the same program on the same processor has the same
  /// bits; other processors differ by the rounding of a converged solve.
  static constexpr double most = 1e-9;

  static double difference_at(const Ray& then, const Ray& now, std::size_t i) {
    if (then.status[i] != now.status[i]) return std::numeric_limits<double>::infinity();
    if (now.status[i] != Status::converged) return 0;
    const auto force = [i](const Ray& ray) { return Eigen::Vector3d::Map(&ray.force[3 * i]); };
    const double of_force = (force(now) - force(then)).norm() / force(then).norm();
    return std::max(of_force, std::abs(now.energy[i] - then.energy[i]) / std::abs(then.energy[i]));
  }

  const DatabaseHeader& _header;
  std::optional<Database> _database;
  std::size_t _n_common = 0;
  std::int32_t _active = -1;
  std::vector<Ray> _rays;
};

}  // namespace phynness
