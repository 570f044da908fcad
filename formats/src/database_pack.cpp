#include "database_pack.hpp"

#include <algorithm>

#include "database_layout.hpp"
#include "durable_file.hpp"

namespace phynness {
namespace layout = database_layout;
namespace path = database_layout::path;
namespace dl = database_log;
namespace {

/// Small arrays of several active nodes, which are collected and written together.
struct SmallArrays {
  std::vector<std::int8_t> status;
  std::vector<double> force, energy, tangent, min_jacobian, seconds;
  std::vector<std::int32_t> negative_pivots, iterations, cutbacks;
  std::vector<std::int8_t> end_reason;
  std::vector<double> end_depth, fold_depth, energy_lost;

  void add(const Ray& ray) {
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    for (Status s : ray.status) status.push_back(static_cast<std::int8_t>(s));
    append(force, ray.force);
    append(energy, ray.energy);
    append(tangent, ray.tangent);
    append(negative_pivots, ray.negative_pivots);
    append(iterations, ray.iterations);
    append(cutbacks, ray.cutbacks);
    append(min_jacobian, ray.min_jacobian);
    append(seconds, ray.seconds);
    end_reason.push_back(static_cast<std::int8_t>(ray.end.reason));
    end_depth.push_back(ray.end.depth_m);
    fold_depth.push_back(ray.end.fold_depth_m);
    energy_lost.push_back(ray.end.energy_lost_J);
  }
  void write(hdf5::File& file, hsize_t first, hsize_t count) const {
    file.write_slab(path::status, first, count, status.data());
    file.write_slab(path::force, first, count, force.data());
    file.write_slab(path::energy, first, count, energy.data());
    if (!tangent.empty()) file.write_slab(path::tangent, first, count, tangent.data());
    file.write_slab(path::negative_pivots, first, count, negative_pivots.data());
    file.write_slab(path::iterations, first, count, iterations.data());
    file.write_slab(path::cutbacks, first, count, cutbacks.data());
    file.write_slab(path::min_jacobian, first, count, min_jacobian.data());
    file.write_slab(path::seconds, first, count, seconds.data());
    file.write_slab(path::end_reason, first, count, end_reason.data());
    file.write_slab(path::end_depth, first, count, end_depth.data());
    file.write_slab(path::fold_depth, first, count, fold_depth.data());
    file.write_slab(path::energy_lost, first, count, energy_lost.data());
  }
};

void write_responses(hdf5::File& out, const DatabaseHeader& header, const dl::Index& index,
                     const std::vector<dl::Entry>& records, const MirroredRays& mirrored) {
  dl::RayReader reader(index, header);
  const hsize_t batch = layout::nodes_per_chunk(header), n_active = header.sets.active.size();

  layout::create_responses(out, header);
  for (hsize_t first = 0; first < n_active; first += batch) {
    const hsize_t count = std::min(batch, n_active - first);
    SmallArrays small;
    for (hsize_t active = first; active < first + count; ++active) {
      std::vector<double> displacement;
      std::vector<std::vector<double>> fields(header.fields.size());
      for (std::size_t d = 0; d < header.directions.size(); ++d) {
        Ray ray = reader.read(records[active * header.directions.size() + d]);
        const auto a = static_cast<std::int32_t>(active), direction = static_cast<std::int32_t>(d);
        if (!mirrored.is_solved(a, direction)) ray = mirrored.image(ray, a, direction);
        small.add(ray);
        displacement.insert(displacement.end(), ray.displacement.begin(), ray.displacement.end());
        for (std::size_t f = 0; f < fields.size(); ++f)
          fields[f].insert(fields[f].end(), ray.fields[f].begin(), ray.fields[f].end());
      }
      out.write_slab(path::displacement, active, 1, displacement.data());
      for (std::size_t f = 0; f < fields.size(); ++f)
        out.write_slab(layout::path_of(header.fields[f]), active, 1, fields[f].data());
    }
    small.write(out, first, count);
  }
}

}  // namespace

std::vector<dl::Entry> one_record_per_ray(const dl::Index& index, const DatabaseHeader& header,
                                          const MirroredRays& mirrored) {
  const std::size_t n_directions = header.directions.size();
  std::vector<dl::Entry> records(header.sets.active.size() * n_directions, dl::Entry{-1, -1, -1, -1});
  const auto record_of = [&](std::int32_t active, std::int32_t direction) -> dl::Entry& {
    return records[static_cast<std::size_t>(active) * n_directions + static_cast<std::size_t>(direction)];
  };
  for (const auto& entry : index.entries) {
    if (!mirrored.is_solved(entry.active, entry.direction)) continue;
    auto& slot = record_of(entry.active, entry.direction);
    if (is_missing(slot)) slot = entry;
  }
  for (std::int32_t a = 0; a < static_cast<std::int32_t>(header.sets.active.size()); ++a)
    for (std::int32_t d = 0; d < static_cast<std::int32_t>(n_directions); ++d) {
      const auto& source = mirrored.source(a, d);
      if (!source.is_itself()) record_of(a, d) = record_of(source.active, source.direction);
    }
  return records;
}

std::vector<std::pair<std::int32_t, std::int32_t>> missing_rays(const std::vector<dl::Entry>& records,
                                                                const MirroredRays& mirrored) {
  std::vector<std::pair<std::int32_t, std::int32_t>> missing;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (!is_missing(records[i])) continue;
    const auto active = static_cast<std::int32_t>(i / mirrored.n_directions());
    const auto direction = static_cast<std::int32_t>(i % mirrored.n_directions());
    if (mirrored.is_solved(active, direction)) missing.emplace_back(active, direction);
  }
  return missing;
}

void write_packed(const std::filesystem::path& file, const DatabaseHeader& header, const dl::Index& index,
                  const std::vector<dl::Entry>& records, const MirroredRays& mirrored) {
  const std::filesystem::path packing = file.string() + ".packing";
  try {
    auto out = hdf5::File::create(packing);
    layout::write_header(out, header, true);
    write_responses(out, header, index, records, mirrored);
    out.close();
    replace_durably(packing, file);
  } catch (...) {
    std::error_code code;
    std::filesystem::remove(packing, code);
    throw;
  }
}

}  // namespace phynness
