// Reading a finished database.
#include <algorithm>
#include <limits>
#include <phynness/formats/database.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/mirrored_rays.hpp>

#include "database_checks.hpp"
#include "database_layout.hpp"
#include "database_log.hpp"
#include "database_scan.hpp"
#include "hdf5_damaged.hpp"
#include "ray_checks.hpp"
#include "ray_ends.hpp"

namespace phynness {
namespace layout = database_layout;
namespace path = database_layout::path;

const char* name(Status status) {
  switch (status) {
    case Status::converged:
      return "converged";
    case Status::not_requested:
      return "not_requested";
    case Status::not_solved:
      return "not_solved";
    case Status::after_end:
      return "after_end";
    case Status::inverted:
      return "inverted";
    case Status::diverged:
      return "diverged";
    case Status::factorization:
      return "factorization";
    case Status::not_finite:
      return "not_finite";
    case Status::after_failure:
      return "after_failure";
    case Status::library_error:
      return "library_error";
  }
  return "unknown";
}

const char* meaning(Status status) {
  switch (status) {
    case Status::converged:
      return "solved";
    case Status::not_requested:
      return "direction outside the hemisphere";
    case Status::not_solved:
      return "no result yet";
    case Status::after_end:
      return "not solved: the ray ends before, at a fold, a crushed cell or the force limit";
    case Status::inverted:
      return "a cell was inverted, even with the smallest steps";
    case Status::diverged:
      return "Newton's method found no equilibrium, even with the smallest steps";
    case Status::factorization:
      return "the tangent was singular or could not be factorized";
    case Status::not_finite:
      return "force, energy or a field was infinite or undefined: mostly a cell was crushed";
    case Status::after_failure:
      return "not tried: an earlier increment of the ray failed";
    case Status::library_error:
      return "a library call failed or memory ran out; see the solver's log";
  }
  return "unknown";
}

struct Database::Impl {
  hdf5::File file;
  DatabaseHeader header;
  double farthest_m = largest_displacement(header.mesh);
  bool records_ends = layout::records_ends(file);

  std::size_t states_per_node() const { return header.directions.size() * header.magnitudes_m.size(); }
  template <class T>
  std::vector<T> of_node(const char* name, std::int32_t active, std::size_t per_state = 1) const {
    std::vector<T> values(states_per_node() * per_state);
    file.read_slab(name, static_cast<hsize_t>(active), 1, values.data());
    return values;
  }
  template <class T>
  std::vector<T> of_all(const char* name) const {
    return file.read<T>(name, {header.sets.active.size(), header.directions.size(), header.magnitudes_m.size()});
  }
  void check_shapes() const;
  void check_mirror() const;
  /// Figures of all increments, [active][direction][increment] flattened. @throws Error (input) if a status is unknown
  StateFigures figures() const;
  /// Ends of the rays of `count` active nodes, as stored. @pre records_ends
  std::vector<RayEnd> stored_ends(std::int32_t first, std::size_t count) const;
  /// @throws Error (input) unless `defect` is empty
  void refuse_damaged(const std::string& defect, const std::string& whose) const;
};

void Database::Impl::check_shapes() const {
  const hdf5::Shape states{header.sets.active.size(), header.directions.size(), header.magnitudes_m.size()};
  const auto check = [&](const std::string& name, const hdf5::Shape& tail) {
    hdf5::Shape expected = states;
    expected.insert(expected.end(), tail.begin(), tail.end());
    file.require_shape(name, expected);
  };
  for (const char* name : {path::status, path::energy, path::negative_pivots, path::iterations, path::cutbacks,
                           path::min_jacobian, path::seconds})
    check(name, {});
  check(path::force, {3});
  if (header.tangents) check(path::tangent, {3, 3});
  if (records_ends)
    for (const char* name : {path::end_reason, path::end_depth, path::fold_depth, path::energy_lost})
      file.require_shape(name, {header.sets.active.size(), header.directions.size()});
  check(path::displacement, {header.sets.output.size(), 3});
  for (const auto field : header.fields) check(layout::path_of(field), {header.sets.output.size()});
}

void Database::Impl::check_mirror() const {
  if (!header.sets.mirror) return;
  const MirroredRays mirrored(header);  // throws for sets that the mirror plane does not map onto themselves
  const auto solved_as =
      file.read<std::int32_t>(path::solved_as, {header.sets.active.size(), header.directions.size()});
  const auto n = static_cast<std::int64_t>(solved_as.size());
  for (std::int64_t ray = 0; ray < n; ++ray) {
    const std::int64_t source = solved_as[static_cast<std::size_t>(ray)];
    if (source < 0 || source >= n || solved_as[static_cast<std::size_t>(source)] != source)
      throw input_error(
          "the database " + file.path().string() + ": " + path::solved_as + " must name rays that were solved",
          "ray " + std::to_string(ray) + " names ray " + std::to_string(source), hdf5::damaged);
  }
}

void Database::Impl::refuse_damaged(const std::string& defect, const std::string& whose) const {
  if (!defect.empty())
    throw input_error("the database " + file.path().string() + " has an impossible number in " + whose, defect,
                      hdf5::damaged);
}

std::vector<RayEnd> Database::Impl::stored_ends(std::int32_t first, std::size_t count) const {
  std::vector<RayEnd> ends(count * header.directions.size());
  std::vector<std::int8_t> reasons(ends.size());
  std::vector<double> depths(ends.size()), folds(ends.size()), losses(ends.size());
  file.read_slab(path::end_reason, static_cast<hsize_t>(first), count, reasons.data());
  file.read_slab(path::end_depth, static_cast<hsize_t>(first), count, depths.data());
  file.read_slab(path::fold_depth, static_cast<hsize_t>(first), count, folds.data());
  file.read_slab(path::energy_lost, static_cast<hsize_t>(first), count, losses.data());
  for (std::size_t i = 0; i < ends.size(); ++i)
    ends[i] = {static_cast<EndReason>(reasons[i]), depths[i], folds[i], losses[i]};
  refuse_damaged(ends_defect(ends), "the list of the ends of rays");
  return ends;
}

StateFigures Database::Impl::figures() const {
  StateFigures all{of_all<std::int8_t>(path::status),      of_all<std::int32_t>(path::negative_pivots),
                   of_all<std::int32_t>(path::iterations), of_all<std::int32_t>(path::cutbacks),
                   of_all<double>(path::min_jacobian),     of_all<double>(path::seconds)};
  refuse_damaged(figures_defect(all), "the list of all increments");
  return all;
}

Database::Database(std::unique_ptr<Impl> impl) : _impl(std::move(impl)) {}
Database::~Database() = default;
Database::Database(Database&&) noexcept = default;
Database& Database::operator=(Database&&) noexcept = default;

bool Database::is_complete(const std::filesystem::path& file) { return layout::read_complete(hdf5::File::open(file)); }

Database Database::open(const std::filesystem::path& file) {
  auto opened = hdf5::File::open(file);
  if (!layout::read_complete(opened)) {
    opened.close();
    const auto progress = database_progress(file);
    if (progress.shard)
      throw input_error(
          "the file " + file.string() + " is a shard of a database", progress.shard->str(),
          "merge all shards with: phynness merge SHARD... -o " + database_of(file, *progress.shard).string());
    throw input_error(
        "the database " + file.string() + " is unfinished",
        std::to_string(progress.rays_logged) + " of " + std::to_string(progress.rays_total) + " rays are solved",
        "finish it with: phynness precompute SCENE -o " + file.string() + " --resume");
  }
  auto header = layout::read_header(opened);
  auto impl = std::make_unique<Impl>(Impl{std::move(opened), std::move(header)});
  impl->check_shapes();
  impl->check_mirror();
  return Database(std::move(impl));
}

const DatabaseHeader& Database::header() const { return _impl->header; }

std::vector<Status> Database::statuses() const {
  const auto codes = _impl->figures().status;
  std::vector<Status> result(codes.size());
  std::transform(codes.begin(), codes.end(), result.begin(),
                 [](std::int8_t code) { return static_cast<Status>(code); });
  return result;
}

std::vector<Ray> Database::rays(std::int32_t active) const {
  const auto& header = _impl->header;
  if (active < 0 || active >= static_cast<std::int32_t>(header.sets.active.size()))
    throw input_error("the database has no such active node", std::to_string(active),
                      "give an index from 0 to " + std::to_string(header.sets.active.size() - 1));
  const std::size_t output = 3 * header.sets.output.size();
  const auto status = _impl->of_node<std::int8_t>(path::status, active);
  const auto force = _impl->of_node<double>(path::force, active, 3);
  const auto energy = _impl->of_node<double>(path::energy, active);
  const auto tangent = header.tangents ? _impl->of_node<double>(path::tangent, active, 9) : std::vector<double>{};
  const auto pivots = _impl->of_node<std::int32_t>(path::negative_pivots, active);
  const auto iterations = _impl->of_node<std::int32_t>(path::iterations, active);
  const auto cutbacks = _impl->of_node<std::int32_t>(path::cutbacks, active);
  const auto jacobian = _impl->of_node<double>(path::min_jacobian, active);
  const auto seconds = _impl->of_node<double>(path::seconds, active);
  const auto displacement = _impl->of_node<double>(path::displacement, active, output);

  std::vector<std::vector<double>> fields;
  for (const auto field : header.fields)
    fields.push_back(_impl->of_node<double>(layout::path_of(field).c_str(), active, header.sets.output.size()));

  const auto ends = _impl->records_ends ? _impl->stored_ends(active, 1) : std::vector<RayEnd>{};

  const std::size_t n = header.magnitudes_m.size();
  std::vector<Ray> rays(header.directions.size());
  for (std::size_t d = 0; d < rays.size(); ++d) {
    const auto part = [&](const auto& values, std::size_t per_state) {
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(d * n * per_state);
      return std::decay_t<decltype(values)>(begin, begin + static_cast<std::ptrdiff_t>(n * per_state));
    };
    Ray& ray = rays[d];
    ray.active = active;
    ray.direction = static_cast<std::int32_t>(d);
    for (std::int8_t code : part(status, 1)) ray.status.push_back(static_cast<Status>(code));
    ray.force = part(force, 3);
    ray.energy = part(energy, 1);
    if (header.tangents) ray.tangent = part(tangent, 9);
    ray.negative_pivots = part(pivots, 1);
    ray.iterations = part(iterations, 1);
    ray.cutbacks = part(cutbacks, 1);
    ray.min_jacobian = part(jacobian, 1);
    ray.seconds = part(seconds, 1);
    ray.displacement = part(displacement, output);
    for (const auto& values : fields) ray.fields.push_back(part(values, header.sets.output.size()));
    ray.end = ends.empty() ? end_of(ray.status, header.magnitudes_m) : ends[d];
    _impl->refuse_damaged(ray_defect(ray, header.fields, _impl->farthest_m),
                          "node " + std::to_string(header.sets.active[static_cast<std::size_t>(active)]) +
                              ", direction " + std::to_string(d));
  }
  return rays;
}

DatabaseSummary summarize(const Database& database) {
  const auto& impl = *database._impl;
  const auto figures = impl.figures();

  DatabaseSummary summary;
  double smallest = std::numeric_limits<double>::infinity();
  const std::size_t n = impl.header.magnitudes_m.size();
  for (std::size_t ray = 0; ray < figures.status.size(); ray += n) {
    bool requested = false, failed = false;
    for (std::size_t i = ray; i < ray + n; ++i) {
      const auto status = static_cast<Status>(figures.status[i]);
      ++summary.states[status];
      requested |= status != Status::not_requested;
      failed |= figures.status[i] < 0;
      summary.newton_iterations += figures.iterations[i];
      summary.seconds += figures.seconds[i];
      if (status != Status::converged) continue;
      summary.unstable_states += figures.negative_pivots[i] > 0;
      smallest = std::min(smallest, figures.min_jacobian[i]);
    }
    summary.rays += requested;
    summary.failed_rays += failed;
  }
  if (summary.states.count(Status::converged)) summary.min_jacobian = smallest;
  return summary;
}

std::vector<RayEnd> Database::ends() const {
  const auto& header = _impl->header;
  if (_impl->records_ends) return _impl->stored_ends(0, header.sets.active.size());
  const auto all = statuses();
  const auto n = static_cast<std::ptrdiff_t>(header.magnitudes_m.size());
  std::vector<RayEnd> ends;
  for (auto ray = all.begin(); ray != all.end(); ray += n)
    ends.push_back(end_of(std::vector<Status>(ray, ray + n), header.magnitudes_m));
  return ends;
}

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
