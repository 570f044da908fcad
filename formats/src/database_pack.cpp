#include "database_pack.hpp"

#include <algorithm>

#include "database_layout.hpp"
#include "durable_file.hpp"
#include "ray_columns.hpp"

namespace phynness {
namespace layout = database_layout;
namespace dl = database_log;
namespace {

/// Columns of rays that follow one another in the file, which are collected and written together.
class Collected {
 public:
  explicit Collected(std::vector<StoredColumn> columns) : _columns(std::move(columns)), _bytes(_columns.size()) {}

  void add(const Ray& ray) {
    for (std::size_t i = 0; i < _columns.size(); ++i)
      std::visit(
          [&](auto member) {
            const auto bytes = std::as_bytes(values_of(ray, member));
            _bytes[i].insert(_bytes[i].end(), bytes.begin(), bytes.end());
          },
          _columns[i].member);
  }
  /// Writes what was added as that of `count` active nodes, and forgets it.
  void write(hdf5::File& file, hsize_t first, hsize_t count) {
    for (std::size_t i = 0; i < _columns.size(); ++i) {
      std::visit(
          [&](auto member) {
            using Value = ValueOf<decltype(member)>;
            file.write_slab(_columns[i].path, first, count, reinterpret_cast<const Value*>(_bytes[i].data()));
          },
          _columns[i].member);
      _bytes[i].clear();
    }
  }

 private:
  std::vector<StoredColumn> _columns;
  std::vector<std::vector<std::byte>> _bytes;
};

void write_responses(hdf5::File& out, const DatabaseHeader& header, const dl::Index& index,
                     const std::vector<dl::Entry>& records, const MirroredRays& mirrored) {
  dl::RayReader reader(index, header);
  const hsize_t batch = layout::nodes_per_chunk(header), n_active = header.sets.active.size();
  Collected of_node(columns_of(header, ColumnOf::output_node)), of_batch(columns_of(header, ColumnOf::increment)),
      ends(columns_of(header, ColumnOf::ray));

  layout::create_responses(out, header);
  for (hsize_t first = 0; first < n_active; first += batch) {
    const hsize_t count = std::min(batch, n_active - first);
    for (hsize_t active = first; active < first + count; ++active) {
      for (std::size_t d = 0; d < header.directions.size(); ++d) {
        Ray ray = reader.read(records[active * header.directions.size() + d]);
        const auto a = static_cast<std::int32_t>(active), direction = static_cast<std::int32_t>(d);
        if (!mirrored.is_solved(a, direction)) ray = mirrored.image(ray, a, direction);
        for (auto* collected : {&of_node, &of_batch, &ends}) collected->add(ray);
      }
      of_node.write(out, active, 1);
    }
    of_batch.write(out, first, count);
    ends.write(out, first, count);
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
