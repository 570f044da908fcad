#include "database_pack.hpp"

#include <algorithm>
#include <optional>

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

/// A part of the active nodes, which begins and ends with chunks.
struct Nodes {
  hsize_t first, end;
};

/// The chunks of some nodes in the order in which they lie in the file.
std::vector<hdf5::File::Chunk> chunks_of(const DatabaseHeader& header, Nodes nodes) {
  std::vector<hdf5::File::Chunk> chunks;
  const auto add = [&](const StoredColumn& column, hsize_t active) {
    const auto shape = layout::chunk_shape(column, header);
    if (shape.empty()) return;
    for (hsize_t direction = 0; direction < header.directions.size(); direction += shape[1]) {
      chunks.push_back({column.path, hdf5::Shape(shape.size(), 0)});
      chunks.back().first[0] = active;
      chunks.back().first[1] = direction;
    }
  };
  const auto of_node = columns_of(header, ColumnOf::output_node), of_batch = columns_of(header, ColumnOf::increment),
             ends = columns_of(header, ColumnOf::ray);
  const auto batch = layout::nodes_per_chunk(header);
  for (auto first = nodes.first; first < nodes.end; first += batch) {
    for (auto active = first; active < std::min(first + batch, nodes.end); ++active)
      for (const auto& column : of_node) add(column, active);
    for (const auto* columns : {&of_batch, &ends})
      for (const auto& column : *columns) add(column, first);
  }
  return chunks;
}

class Packing {
 public:
  Packing(const DatabaseHeader& header, const dl::Index& index, const std::vector<dl::Entry>& records,
          const MirroredRays& mirrored)
      : _header(header), _records(records), _mirrored(mirrored), _reader(index, header) {}

  /// Writes FILE and makes it durable, collectively.
  void write(const std::filesystem::path& file, const PackingRanks& ranks);

 private:
  /// Compressed chunks of some nodes, one after another.
  struct Chunks {
    std::vector<unsigned char> bytes;
    std::vector<std::int64_t> sizes;  ///< in the lower 32 bits, and above them the filters that were not applied
  };
  static std::uint32_t lower(std::int64_t size) { return static_cast<std::uint32_t>(size); }

  Chunks compress(Nodes nodes);
  std::vector<std::int64_t> reserve(hdf5::File& out, const std::filesystem::path& file, Nodes nodes,
                                    const std::vector<std::int64_t>& sizes) const;
  hsize_t nodes_per_round(const PackingRanks& ranks) const;

  const DatabaseHeader& _header;
  const std::vector<dl::Entry>& _records;
  const MirroredRays& _mirrored;
  dl::RayReader _reader;
};

/// As HDF5 does it, in a file in memory.
Packing::Chunks Packing::compress(Nodes nodes) {
  const auto batch = layout::nodes_per_chunk(_header);
  const auto n_directions = _header.directions.size();
  Collected of_node(columns_of(_header, ColumnOf::output_node)), of_batch(columns_of(_header, ColumnOf::increment)),
      ends(columns_of(_header, ColumnOf::ray));
  Chunks chunks;
  if (nodes.first >= nodes.end) return chunks;
  auto memory = hdf5::File::create_in_memory();
  layout::create_responses(memory, _header);
  for (auto first = nodes.first; first < nodes.end; first += batch) {
    const auto count = std::min(batch, nodes.end - first);
    for (auto active = first; active < first + count; ++active) {
      for (std::size_t d = 0; d < n_directions; ++d) {
        Ray ray = _reader.read(_records[active * n_directions + d]);
        const auto a = static_cast<std::int32_t>(active), direction = static_cast<std::int32_t>(d);
        if (!_mirrored.is_solved(a, direction)) ray = _mirrored.image(ray, a, direction);
        for (auto* collected : {&of_node, &of_batch, &ends}) collected->add(ray);
      }
      of_node.write(memory, active, 1);
    }
    of_batch.write(memory, first, count);
    ends.write(memory, first, count);
  }
  for (const auto& chunk : chunks_of(_header, nodes)) {
    const auto before = chunks.bytes.size();
    const std::int64_t filters = memory.read_chunk(chunk, chunks.bytes);
    chunks.sizes.push_back(static_cast<std::int64_t>(chunks.bytes.size() - before) | filters << 32);
  }
  return chunks;
}

/// @return offsets in the file
std::vector<std::int64_t> Packing::reserve(hdf5::File& out, const std::filesystem::path& file, Nodes nodes,
                                           const std::vector<std::int64_t>& sizes) const {
  std::vector<std::int64_t> places;
  std::int64_t end = 0;
  for (const auto& chunk : chunks_of(_header, nodes)) {
    const auto size = sizes[places.size()];
    places.push_back(out.reserve_chunk(chunk, lower(size), static_cast<std::uint32_t>(size >> 32)));
    end = std::max(end, places.back() + lower(size));
  }
  // So that no machine of a network file system takes what others write for the empty rest of its last page.
  if (end > static_cast<std::int64_t>(std::filesystem::file_size(file)))
    std::filesystem::resize_file(file, static_cast<std::uintmax_t>(end));
  return places;
}

/// Of one rank. Memory limits it, and that all ranks have something to do.
hsize_t Packing::nodes_per_round(const PackingRanks& ranks) const {
  constexpr double round_bytes = 64e6;
  const auto batch = layout::nodes_per_chunk(_header), n_ranks = static_cast<hsize_t>(ranks.size);
  const auto n_batches = (_header.sets.active.size() + batch - 1) / batch;
  const double batch_bytes =
      static_cast<double>(batch * _header.directions.size()) * static_cast<double>(dl::Layout(_header).record_bytes());
  return batch * std::clamp<hsize_t>(static_cast<hsize_t>(round_bytes / batch_bytes), 1,
                                     std::max<hsize_t>(1, (n_batches + n_ranks - 1) / n_ranks));
}

void Packing::write(const std::filesystem::path& file, const PackingRanks& ranks) {
  std::optional<hdf5::File> out;
  ranks.together([&] {
    if (ranks.rank != 0) return;
    layout::write_header(out.emplace(hdf5::File::create(file)), _header, true);
    layout::create_responses(*out, _header);
  });
  const hsize_t n = _header.sets.active.size(), share = nodes_per_round(ranks);
  for (hsize_t first = 0; first < n; first += share * static_cast<hsize_t>(ranks.size)) {
    const auto part = [&](hsize_t rank) { return std::min(n, first + rank * share); };
    const auto rank = static_cast<hsize_t>(ranks.rank);
    Chunks own;
    ranks.together([&] { own = compress({part(rank), part(rank + 1)}); });
    const auto sizes = ranks.gathered(own.sizes);
    std::vector<std::int64_t> places;
    ranks.together([&] {
      if (out) places = reserve(*out, file, {first, part(static_cast<hsize_t>(ranks.size))}, sizes);
    });
    places = ranks.gathered(places);
    const auto before = chunks_of(_header, {first, part(rank)}).size();
    ranks.together([&] {
      const auto target = open_for_writing(file);
      const auto* bytes = own.bytes.data();
      for (std::size_t i = 0; i < own.sizes.size(); bytes += lower(own.sizes[i++]))
        write_at(target, file, places[before + i], bytes, lower(own.sizes[i]));
    });
  }
  ranks.together([&] {
    if (out) out->close();
    sync_file(file);
  });
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
                  const std::vector<dl::Entry>& records, const MirroredRays& mirrored, const PackingRanks& ranks) {
  const std::filesystem::path packing = file.string() + ".packing";
  try {
    Packing(header, index, records, mirrored).write(packing, ranks);
    ranks.together([&] {
      if (ranks.rank == 0) replace_durably(packing, file);
    });
  } catch (...) {
    std::error_code code;
    if (ranks.rank == 0) std::filesystem::remove(packing, code);
    throw;
  }
}

}  // namespace phynness
