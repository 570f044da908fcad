// Reading a finished database.
#include <algorithm>
#include <cmath>
#include <limits>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>

#include "database_layout.hpp"
#include "database_log.hpp"
#include "database_scan.hpp"
#include "database_study.hpp"

namespace phynness {
namespace layout = database_layout;
namespace path = database_layout::path;

struct Database::Impl {
  hdf5::File file;
  DatabaseHeader header;
  std::vector<StoredColumn> columns = columns_of(header);
  double farthest_m = largest_displacement(header.mesh);
  std::optional<DatabaseHeader> whole = {};  ///< of the file, if `header` is that of a part of its nodes

  std::vector<StoredColumn> columns_with(ColumnOf of) const { return columns_of(header, of); }

  /// A column of `count` active nodes, one ray after the other.
  template <class Value>
  std::vector<Value> values(const StoredColumn& column, std::size_t first, std::size_t count) const {
    const std::size_t n_directions = header.directions.size();
    std::vector<Value> all(count * n_directions * column.count);
    if (!whole) {
      file.read_slab(column.path, first, count, all.data());
      return all;
    }
    const auto position = [](const NodeList& nodes, std::int32_t node) {
      return static_cast<std::size_t>(std::ranges::lower_bound(nodes, node) - nodes.begin());
    };
    const bool at_nodes = column.of == ColumnOf::output_node;
    const std::size_t n_output = at_nodes ? header.sets.output.size() : 1,
                      n_stored = at_nodes ? whole->sets.output.size() : 1,
                      size = static_cast<std::size_t>(column.tensor),
                      n = n_directions * column.count / n_output;  // values of a node, per output node
    std::vector<Value> node(n * n_stored);
    for (std::size_t i = 0; i < count; ++i) {
      file.read_slab(column.path, position(whole->sets.active, header.sets.active[first + i]), 1, node.data());
      for (std::size_t o = 0; o < n_output; ++o) {
        const auto from = at_nodes ? position(whole->sets.output, header.sets.output[o]) : 0;
        for (std::size_t k = 0; k < n / size; ++k)
          std::copy_n(&node[(k * n_stored + from) * size], size, &all[((i * n / size + k) * n_output + o) * size]);
      }
    }
    return all;
  }
  /// Reads a column of `count` active nodes into rays that have room for it.
  void read(const StoredColumn& column, std::int32_t first, std::size_t count, std::span<Ray> rays) const {
    std::visit(
        [&](auto member) {
          const auto all = values<ValueOf<decltype(member)>>(column, static_cast<std::size_t>(first), count);
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
  }

  /// @throws Error (input) if a number of these columns is impossible
  void refuse_damaged(const Ray& ray, const std::vector<StoredColumn>& wanted, const std::string& whose) const {
    const auto defect = ray_defect(ray, wanted, farthest_m);
    if (!defect.empty())
      throw input_error("the database " + file.path().string() + " has an impossible number in " + whose, defect,
                        hdf5::damaged);
  }

  /// Some columns of all increments of the database as one ray, checked. @pre the first column is that of the outcomes
  Ray all_increments(const std::vector<StoredColumn>& wanted) const {
    Ray all;
    const std::size_t n_active = header.sets.active.size();
    for (const auto& column : wanted) {
      resize_values(all, column, n_active * header.directions.size() * column.count);
      read(column, 0, n_active, {&all, 1});
    }
    refuse_damaged(all, wanted, "the list of all increments");
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

Database Database::open(const std::filesystem::path& file, const DatabaseHeader& wanted) {
  Database database = open(file);
  auto& impl = *database._impl;
  refuse_other_rays(impl.header, wanted, file);
  impl.whole = std::exchange(impl.header, wanted);
  impl.columns = columns_of(wanted);
  return database;
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
    _impl->refuse_damaged(ray, _impl->columns,
                          "node " + std::to_string(header.sets.active[static_cast<std::size_t>(active)]) +
                              ", direction " + std::to_string(ray.direction));
  return rays;
}

namespace {

/// Over the increments that converged.
template <class T>
ColumnRange range_of(const StoredColumn& column, std::span<const T> values, const std::vector<Status>& status) {
  ColumnRange range{column.name, column.unit, std::numeric_limits<double>::infinity(),
                    -std::numeric_limits<double>::infinity()};
  const std::size_t per_increment = values.size() / status.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (status[i / per_increment] != Status::converged) continue;
    range.smallest = std::min(range.smallest, static_cast<double>(values[i]));
    range.largest = std::max(range.largest, static_cast<double>(values[i]));
  }
  return range;
}

}  // namespace

DatabaseSummary summarize(const Database& database) {
  const auto& impl = *database._impl;
  const auto columns = impl.columns_with(ColumnOf::increment);
  const Ray all = impl.all_increments(columns);

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
  if (!summary.states.count(Status::converged)) return summary;
  summary.min_jacobian = smallest;
  for (const auto& column : columns) {
    if (column.kind == ColumnKind::code) continue;
    std::visit(
        [&](auto member) {
          if constexpr (!std::is_enum_v<ValueOf<decltype(member)>>)
            summary.ranges.push_back(range_of<ValueOf<decltype(member)>>(column, values_of(all, member), all.status));
        },
        column.member);
  }
  return summary;
}

std::vector<RayEnd> Database::ends() const {
  const auto& header = _impl->header;
  std::vector<RayEnd> ends;
  const auto columns = _impl->columns_with(ColumnOf::ray);
  std::vector<Ray> rays(header.sets.active.size() * header.directions.size());
  for (const auto& column : columns) _impl->read(column, 0, header.sets.active.size(), rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    _impl->refuse_damaged(rays[i], columns, "ray " + std::to_string(i));
    ends.push_back(rays[i].end);
  }
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
