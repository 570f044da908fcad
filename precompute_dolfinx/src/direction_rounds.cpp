#include "direction_rounds.hpp"

#include <mpi.h>

#include <algorithm>
#include <limits>

namespace phynness {

DirectionRounds::DirectionRounds(const Scene& scene, const DatabaseHeader& header, std::vector<char> requested,
                                 ErrorPrediction predict)
    : _header(header),
      _requested(std::move(requested)),
      _predict(scene.probe.target_error ? std::move(predict) : ErrorPrediction()),
      _target(scene.probe.target_error.value_or(0)),
      _rounds(header.sets.active.size(), _predict ? 0 : n_direction_rounds),
      _errors(header.sets.active.size(), -1) {}

bool DirectionRounds::is_wanted(std::int32_t active, std::size_t direction) const {
  return _requested[index(active, direction)] != 0 &&
         direction_round(direction) <= _rounds[static_cast<std::size_t>(active)];
}

std::vector<RayIndex> DirectionRounds::left(const std::vector<char>& logged) const {
  std::vector<char> none_left(logged.size(), 1);
  const auto n_active = static_cast<std::int32_t>(_rounds.size());
  for (std::int32_t active = 0; active < n_active; ++active)
    for (std::size_t direction = 0; direction < _header.directions.size(); ++direction)
      if (const auto ray = index(active, direction); is_wanted(active, direction)) none_left[ray] = logged[ray];
  return rays_left(_header, none_left);
}

void DirectionRounds::read(const SolverSession& session, const std::filesystem::path& file) {
  const std::size_t n_rays = _requested.size(), n = _header.magnitudes_m.size();
  _statuses.assign(n_rays * n, Status::not_solved);
  _forces.assign(3 * n_rays * n, 0);
  _depths_m.assign(n_rays, 0);
  session.together([&] {
    if (session.rank() != 0) return;
    DatabaseWriter::read_logs(file, _header, [&](const Ray& ray) {
      const auto at = index(ray.active, static_cast<std::size_t>(ray.direction));
      std::ranges::copy(ray.status, _statuses.begin() + static_cast<std::ptrdiff_t>(n * at));
      std::ranges::copy(ray.force, _forces.begin() + static_cast<std::ptrdiff_t>(3 * n * at));
      _depths_m[at] = ray.end.depth_m;
    });
  });
  MPI_Bcast(_statuses.data(), static_cast<int>(_statuses.size()), MPI_INT8_T, 0, MPI_COMM_WORLD);
  MPI_Bcast(_forces.data(), static_cast<int>(_forces.size()), MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

double DirectionRounds::predicted(std::int32_t active) const {
  const auto n = static_cast<std::ptrdiff_t>(_header.magnitudes_m.size());
  std::vector<Ray> rays;
  bool ends_early = false;
  for (std::size_t direction = 0; direction < _header.directions.size(); ++direction) {
    Ray& ray = rays.emplace_back();
    const auto at = static_cast<std::ptrdiff_t>(index(active, direction)) * n;
    ray.active = active;
    ray.direction = static_cast<std::int32_t>(direction);
    ray.status.assign(static_cast<std::size_t>(n), Status::not_requested);
    ray.force.assign(_forces.begin() + 3 * at, _forces.begin() + 3 * (at + n));
    if (!is_wanted(active, direction)) continue;
    ray.status.assign(_statuses.begin() + at, _statuses.begin() + at + n);
    ends_early = ends_early || ray.status.back() != Status::converged;
  }
  return ends_early && _rounds[static_cast<std::size_t>(active)] == 0 ? std::numeric_limits<double>::infinity()
                                                                      : _predict(_header, rays);
}

bool DirectionRounds::next(const SolverSession& session, const std::filesystem::path& file) {
  if (!_predict) return false;
  read(session, file);
  const auto n_active = static_cast<std::int32_t>(_rounds.size());
  std::vector<double> errors(_rounds.size(), -1);
  session.together([&] {
    for (std::int32_t active = session.rank(); active < n_active; active += session.size())
      errors[static_cast<std::size_t>(active)] = predicted(active);
  });
  MPI_Allreduce(MPI_IN_PLACE, errors.data(), n_active, MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD);
  _errors = std::move(errors);
  const int last = direction_round(_header.directions.size() - 1) == 2 ? 2 : 1;
  bool adds = false;
  for (std::size_t active = 0; active < _rounds.size(); ++active)
    if (_errors[active] > _target && _rounds[active] < last) {
      ++_rounds[active];
      adds = true;
    }
  return adds;
}

Ray DirectionRounds::left_out(const RayIndex& ray) const {
  Ray out = empty_ray(_header, ray.active, ray.direction);
  const auto& all = _header.directions;
  const auto direction = static_cast<std::size_t>(ray.direction);
  if (!_predict || !_requested[index(ray.active, direction)]) return out;
  const auto e = Eigen::Map<const Eigen::Vector3d>(all[direction].data());
  std::vector<std::pair<double, double>> near;  // minus the cosine, depth
  for (std::size_t d = 0; d < all.size(); ++d)
    if (is_wanted(ray.active, d))
      near.emplace_back(-e.dot(Eigen::Map<const Eigen::Vector3d>(all[d].data())), _depths_m[index(ray.active, d)]);
  if (near.size() < 2) return out;
  std::ranges::partial_sort(near, near.begin() + 2);
  out.end.depth_m = std::min(near[0].second, near[1].second);
  return out;
}

void DirectionRounds::report(PrecomputeReport& report) const {
  if (!_predict) return;
  for (std::size_t active = 0; active < _errors.size(); ++active) {
    if (_errors[active] < 0) continue;
    report.predicted_errors.push_back(_errors[active]);
    report.refined_nodes += _rounds[active] > 0;
  }
}

}  // namespace phynness
