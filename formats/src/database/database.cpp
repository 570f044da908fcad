// Reading a finished database.
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>

#include "database_layout.hpp"
#include "database_log.hpp"
#include "database_scan.hpp"

namespace phynness {
namespace layout = database_layout;
namespace path = database_layout::path;

struct Database::Impl {
  hdf5::File file;
  DatabaseHeader header;
  std::vector<StoredColumn> columns = columns_of(header);

  /// Reads a column of `count` active nodes into rays that have room for it.
  void read(const StoredColumn& column, std::int32_t first, std::size_t count, std::span<Ray> rays) const {
    std::visit(
        [&](auto member) {
          using Value = ValueOf<decltype(member)>;
          std::vector<Value> all(count * header.directions.size() * column.count);
          file.read_slab(column.path, static_cast<std::size_t>(first), count, all.data());
          if constexpr (std::is_enum_v<Value>)
            for (const Value code : all)
              if (std::string_view(name(code)) == "unknown")
                file.refuse(column.path + " has a code that is none of formats/database.md",
                            std::to_string(static_cast<int>(code)));
          auto from = all.begin();
          for (Ray& ray : rays) {
            const auto to = values_of(ray, member);
            std::copy_n(from, to.size(), to.begin());
            from += static_cast<std::ptrdiff_t>(to.size());
          }
        },
        column.member);
  }

  void check_shapes() const {
    for (const auto& column : columns) {
      hdf5::Shape expected{header.sets.active.size(), header.directions.size()};
      expected.insert(expected.end(), column.shape.begin(), column.shape.end());
      file.check_shape(column.path, expected);
    }
    if (header.sets.linear.empty()) return;
    file.check_shape(path::rest_stiffness, {header.sets.linear.size(), 3, 3});
    file.check_shape(path::rest_displacement, {header.sets.linear.size(), 3, header.sets.output.size(), 3});
  }

  /// Some columns of all increments of the database as one ray.
  Ray all_increments(const std::vector<StoredColumn>& wanted) const {
    Ray all;
    const std::size_t n_active = header.sets.active.size();
    for (const auto& column : wanted) {
      resize_values(all, column, n_active * header.directions.size() * column.count);
      read(column, 0, n_active, {&all, 1});
    }
    return all;
  }
};

Database::Database(std::shared_ptr<Impl> impl) : _impl(std::move(impl)) {}

bool Database::is_complete(const std::filesystem::path& file) { return layout::read_complete(hdf5::File::open(file)); }

Database Database::open(const std::filesystem::path& file) {
  auto opened = hdf5::File::open(file);
  if (!layout::read_complete(opened)) {
    opened.close();
    const auto progress = database_progress(file);
    throw input_error(
        "the database " + file.string() + " is unfinished",
        std::to_string(progress.rays_logged) + " of " + std::to_string(progress.rays_total) + " rays are solved",
        "finish it with: phynness precompute SCENE -o " + file.string() + " --resume");
  }
  auto header = layout::read_header(opened);
  auto impl = std::make_shared<Impl>(Impl{std::move(opened), std::move(header)});
  impl->check_shapes();
  return Database(std::move(impl));
}

const DatabaseHeader& Database::header() const { return _impl->header; }

std::vector<Status> Database::statuses() const { return _impl->all_increments({_impl->columns.front()}).status; }

std::vector<Ray> Database::rays(std::int32_t active) const {
  const auto& header = _impl->header;
  if (active < 0 || active >= static_cast<std::int32_t>(header.sets.active.size()))
    throw input_error("the database has no such active node", std::to_string(active),
                      "give an index from 0 to " + std::to_string(header.sets.active.size() - 1));
  std::vector<Ray> rays;
  for (std::size_t d = 0; d < header.directions.size(); ++d)
    rays.push_back(empty_ray(header, active, static_cast<std::int32_t>(d)));
  for (const auto& column : _impl->columns) _impl->read(column, active, 1, rays);
  for (const Ray& ray : rays)
    for (std::size_t i = 0; i < ray.status.size(); ++i) {
      const double *f = &ray.force[3 * i], energy = ray.energy[i];
      if (ray.status[i] == Status::converged && !std::isfinite(f[0] + f[1] + f[2] + energy))
        _impl->file.refuse("a solved increment has a force or an energy that is not finite",
                           "node " + std::to_string(header.sets.active[static_cast<std::size_t>(active)]) +
                               ", direction " + std::to_string(ray.direction));
    }
  return rays;
}

AtRest Database::at_rest(std::int32_t point) const {
  const auto& [file, header, columns] = *_impl;
  if (point < 0 || point >= std::ssize(header.sets.linear))
    throw input_error("the database has no response at rest of such a point", std::to_string(point),
                      "it has " + std::to_string(header.sets.linear.size()) + " of them");
  AtRest response;
  response.displacement.resize(9 * header.sets.output.size());
  const auto at = static_cast<hsize_t>(point);
  file.read_slab(path::rest_stiffness, at, 1, response.stiffness_N_per_m.data());
  file.read_slab(path::rest_displacement, at, 1, response.displacement.data());
  for (const double k : response.stiffness_N_per_m)
    if (!std::isfinite(k))
      file.refuse("a stiffness at rest is not finite",
                  "node " + std::to_string(header.sets.linear[static_cast<std::size_t>(point)]));
  return response;
}

DatabaseSummary summarize(const Database& database) {
  const auto& impl = *database._impl;
  const Ray all = impl.all_increments(columns_of(impl.header, ColumnOf::increment));

  DatabaseSummary summary;
  double smallest = std::numeric_limits<double>::infinity();
  const std::size_t n = impl.header.magnitudes_m.size();
  for (std::size_t ray = 0; ray < all.status.size(); ray += n) {
    bool requested = false, failed = false;
    for (std::size_t i = ray; i < ray + n; ++i) {
      const Status status = all.status[i];
      ++summary.states[status];
      requested |= status != Status::not_requested;
      failed |= static_cast<int>(status) < 0;
      summary.newton_iterations += all.iterations[i];
      summary.seconds += all.seconds[i];
      if (status != Status::converged) continue;
      summary.unstable_states += all.negative_pivots[i] > 0;
      smallest = std::min(smallest, all.min_jacobian[i]);
    }
    summary.rays += requested;
    summary.failed_rays += failed;
  }
  if (summary.states.contains(Status::converged)) summary.min_jacobian = smallest;
  return summary;
}

std::vector<RayEnd> Database::ends() const {
  const auto& header = _impl->header;
  std::vector<Ray> rays(header.sets.active.size() * header.directions.size());
  for (const auto& column : columns_of(header, ColumnOf::ray)) _impl->read(column, 0, header.sets.active.size(), rays);
  std::vector<RayEnd> ends;
  for (const Ray& ray : rays) ends.push_back(ray.end);
  return ends;
}

double EndSummary::share_of_rays() const {
  std::int64_t n = 0;
  for (const auto& [reason, count] : reasons)
    if (RayEnd{reason}.is_early()) n += count;
  return rays == 0 ? 0 : static_cast<double>(n) / static_cast<double>(rays);
}

double EndSummary::share_of_volume() const {
  double share = 0;
  for (const auto& [reason, part] : volume) share += part;
  return share;
}

double part_of_volume(double depth_m, double range_m) { return std::pow(std::min(1.0, depth_m / range_m), 3); }

EndSummary summarize_ends(const DatabaseHeader& header, const std::vector<RayEnd>& ends) {
  EndSummary summary;
  const double full = header.magnitudes_m.back();
  const std::size_t n_directions = header.directions.size();
  // A model is trained up to the last increment before the end; the depths of both may differ by roundings.
  const auto trained_m = [&](double depth_m) {
    const auto beyond = std::upper_bound(header.magnitudes_m.begin(), header.magnitudes_m.end(), depth_m * (1 + 1e-9));
    return beyond == header.magnitudes_m.begin() ? 0.0 : *(beyond - 1);
  };
  for (std::size_t first = 0; first < ends.size(); first += n_directions) {
    double reached = 0;
    std::int32_t requested = 0, early = 0;
    for (std::size_t i = first; i < first + n_directions; ++i) {
      const RayEnd& end = ends[i];
      if (end.reason == EndReason::not_requested) continue;
      ++requested;
      ++summary.reasons[end.reason];
      summary.folds += end.fold_depth_m > 0;
      if (end.fold_depth_m > 0) summary.largest_loss_J = std::max(summary.largest_loss_J, std::abs(end.energy_lost_J));
      const double part = end.is_early() ? part_of_volume(trained_m(end.depth_m), full) : 1.0;
      if (end.is_early()) summary.volume[end.reason] += 1 - part;
      early += end.is_early();
      reached += part;
    }
    summary.rays += requested;
    summary.early.push_back(early);
    summary.reached.push_back(requested > 0 ? reached / requested : 1.0);
  }
  for (auto& entry : summary.volume) entry.second /= static_cast<double>(summary.rays);
  return summary;
}

EndSummary summarize_ends(const Database& database) { return summarize_ends(database.header(), database.ends()); }

DatabaseHeader read_database_header(const std::filesystem::path& file) {
  try {
    return layout::read_header(hdf5::File::open(file));
  } catch (const Error& error) {
    // The file of an unfinished database can be created again, because the results are in its logs.
    std::error_code code;
    if (!std::filesystem::exists(file, code) || database_log::logs_of(file).empty()) throw;
    throw Error(error.kind(), error.what(), "",
                "its finished rays are in " + database_log::folder(file).string() +
                    ": delete the file but not the folder, and run phynness precompute with --resume");
  }
}

}  // namespace phynness
