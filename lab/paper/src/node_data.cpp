#include "node_data.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace phynness::study {
namespace {

constexpr int superposed_increments = 6;  // the paper's

}  // namespace

NodeData::NodeData(const Database& database, bool superpose)
    : _database(database), _header(database.header()), _superpose(superpose) {
  if (_superpose) {
    const double largest = _header.magnitudes_m.back();
    _header.directions = exploratory_directions(Directions::twenty_six);
    _header.magnitudes_m.clear();
    for (int i = 1; i <= superposed_increments; ++i)
      _header.magnitudes_m.push_back(largest * i / superposed_increments);
  }
  _tables = training_tables(_header);
}

std::int32_t NodeData::index_of(std::int32_t node) const {
  const auto& active = _header.sets.active;
  return static_cast<std::int32_t>(std::lower_bound(active.begin(), active.end(), node) - active.begin());
}

const TouchedNodes& NodeData::touched(std::int32_t node) const {
  return _header.sets.tools[static_cast<std::size_t>(index_of(node))];
}

std::vector<Ray> NodeData::rays(std::int32_t node) const {
  const auto index = index_of(node);
  auto stored = _database.rays(index);
  if (!_superpose) return stored;
  const auto& directions = _database.header().directions;
  const auto& magnitudes = _database.header().magnitudes_m;
  Eigen::Matrix3d imposed;
  Eigen::MatrixXd response(3 + 3 * static_cast<Eigen::Index>(_header.sets.output.size()), 3);
  const std::size_t last = magnitudes.size() - 1;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto& e = directions[static_cast<std::size_t>(k)];
    const auto& ray = stored[static_cast<std::size_t>(k)];
    imposed.col(k) = magnitudes.back() * Eigen::Vector3d(e[0], e[1], e[2]);
    for (std::size_t i = 0; i < 3; ++i) response(static_cast<Eigen::Index>(i), k) = ray.force[3 * last + i];
    const auto n = 3 * _header.sets.output.size();
    for (std::size_t i = 0; i < n; ++i) response(static_cast<Eigen::Index>(3 + i), k) = ray.displacement[n * last + i];
  }
  const Eigen::MatrixXd unit = response * imposed.inverse();
  std::vector<Ray> rays;
  for (std::size_t direction = 0; direction < _header.directions.size(); ++direction) {
    Ray ray;
    ray.active = index;
    ray.direction = static_cast<std::int32_t>(direction);
    const auto& e = _header.directions[direction];
    for (const double magnitude : _header.magnitudes_m) {
      const Eigen::VectorXd said = unit * (magnitude * Eigen::Vector3d(e[0], e[1], e[2]));
      ray.status.push_back(Status::converged);
      ray.force.insert(ray.force.end(), said.data(), said.data() + 3);
      ray.displacement.insert(ray.displacement.end(), said.data() + 3, said.data() + said.size());
    }
    rays.push_back(std::move(ray));
  }
  return rays;
}

}  // namespace phynness::study
