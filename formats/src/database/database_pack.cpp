#include "database_pack.hpp"

#include <algorithm>
#include <optional>

#include "database_layout.hpp"
#include "ray_columns.hpp"
#include "text/durable_file.hpp"

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

/// Neighbouring chunks of the file, which one rank compresses: those of the output nodes of one active node, or those
/// of all other columns of as many active nodes as a chunk holds.
struct Item {
  bool of_output_nodes;
  hsize_t first, end;  ///< active nodes
};

/// In their order in the file.
std::vector<Item> items_of(const DatabaseHeader& header) {
  const hsize_t batch = layout::nodes_per_chunk(header), n = header.sets.active.size();
  std::vector<Item> items;
  for (hsize_t first = 0; first < n; first += batch) {
    const auto end = std::min(first + batch, n);
    for (auto active = first; active < end; ++active) items.push_back({true, active, active + 1});
    items.push_back({false, first, end});
  }
  return items;
}

std::vector<StoredColumn> columns_of(const DatabaseHeader& header, const Item& item) {
  if (item.of_output_nodes) return columns_of(header, ColumnOf::output_node);
  auto columns = columns_of(header, ColumnOf::increment);
  for (auto& column : columns_of(header, ColumnOf::ray)) columns.push_back(std::move(column));
  return columns;
}

class Packing {
 public:
  Packing(const DatabaseHeader& header, const dl::Index& index, const std::vector<dl::Entry>& records,
          const PackingRanks& ranks)
      : _header(header), _records(records), _ranks(ranks), _reader(index, header), _items(items_of(header)) {}

  /// Writes FILE, collectively.
  void write(const std::filesystem::path& file, const std::function<AtRest(std::int32_t point)>& at_rest);

 private:
  /// Compressed chunks, one after another.
  struct Compressed {
    std::vector<unsigned char> bytes;
    std::vector<std::int64_t> sizes;  ///< in the lower 32 bits, and above them the filters that were not applied
  };
  static std::uint32_t lower(std::int64_t size) { return static_cast<std::uint32_t>(size); }

  std::vector<hdf5::File::Chunk> chunks_of(std::size_t first, std::size_t end) const;
  Compressed compress(std::size_t first, std::size_t end);
  std::size_t items_per_round() const;

  const DatabaseHeader& _header;
  const std::vector<dl::Entry>& _records;
  const PackingRanks& _ranks;
  dl::RayReader _reader;
  std::vector<Item> _items;
};

/// The chunks of some items in the order in which they lie in the file.
std::vector<hdf5::File::Chunk> Packing::chunks_of(std::size_t first, std::size_t end) const {
  std::vector<hdf5::File::Chunk> chunks;
  for (auto i = first; i < end; ++i)
    for (const auto& column : columns_of(_header, _items[i])) {
      const auto shape = layout::chunk_shape(column, _header);
      if (shape.empty()) continue;
      for (hsize_t direction = 0; direction < _header.directions.size(); direction += shape[1]) {
        chunks.push_back({column.path, hdf5::Shape(shape.size(), 0)});
        chunks.back().first[0] = _items[i].first;
        chunks.back().first[1] = direction;
      }
    }
  return chunks;
}

/// As HDF5 does it, in a file in memory.
Packing::Compressed Packing::compress(std::size_t first, std::size_t end) {
  Compressed compressed;
  if (first == end) return compressed;
  auto memory = hdf5::File::create_in_memory();
  layout::create_responses(memory, _header);
  const auto n_directions = _header.directions.size();
  for (auto i = first; i < end; ++i) {
    const auto& item = _items[i];
    Collected collected(columns_of(_header, item));
    for (auto active = item.first; active < item.end; ++active)
      for (std::size_t d = 0; d < n_directions; ++d) {
        const auto at = active * n_directions + d;
        const Ray ray = _reader.read(_records[at], item.of_output_nodes);
        if (!item.of_output_nodes) _ranks.packed(ray);
        collected.add(ray);
      }
    collected.write(memory, item.first, item.end - item.first);
  }
  for (const auto& chunk : chunks_of(first, end)) {
    const auto before = compressed.bytes.size();
    const std::int64_t filters = memory.read_chunk(chunk, compressed.bytes);
    compressed.sizes.push_back(static_cast<std::int64_t>(compressed.bytes.size() - before) | filters << 32);
  }
  return compressed;
}

/// Of all ranks. The limit is the memory of a rank, and that of rank 0, which gets the chunks of all.
std::size_t Packing::items_per_round() const {
  constexpr std::size_t bytes_of_rank = 32 << 20, bytes_of_all = 1 << 30;
  const auto n_ranks = static_cast<std::size_t>(_ranks.size);
  const auto bytes_of_node = _header.directions.size() * dl::Layout(_header).record_bytes();
  return std::max<std::size_t>(1, std::min(n_ranks * bytes_of_rank, bytes_of_all) / bytes_of_node);
}

void Packing::write(const std::filesystem::path& file, const std::function<AtRest(std::int32_t point)>& at_rest) {
  std::optional<hdf5::File> out;
  _ranks.together([&] {
    if (_ranks.rank != 0) return;
    layout::write_header(out.emplace(hdf5::File::create(file, layout::header_bytes(_header))), _header, true);
    layout::create_responses(*out, _header);
    layout::write_at_rest(*out, _header, at_rest);
  });
  const auto share = items_per_round(), n_ranks = static_cast<std::size_t>(_ranks.size),
             rank = static_cast<std::size_t>(_ranks.rank);
  for (std::size_t first = 0, end = 0; first < _items.size(); first = end) {
    end = std::min(first + share, _items.size());
    const auto part = [&](std::size_t r) { return first + ((end - first) * r + n_ranks - 1) / n_ranks; };
    Compressed own;
    _ranks.together([&] { own = compress(part(rank), part(rank + 1)); });
    const auto sizes = _ranks.gathered(own.sizes);
    const auto bytes = _ranks.to_first(own.bytes);
    _ranks.together([&] {
      if (!out) return;
      const auto chunks = chunks_of(first, end);
      constexpr std::size_t index_bytes = 64;  // of a chunk
      out->reserve(bytes.size() + index_bytes * chunks.size());
      const auto* from = bytes.data();
      for (std::size_t i = 0; i < chunks.size(); from += lower(sizes[i++]))
        out->write_chunk(chunks[i], from, lower(sizes[i]), static_cast<std::uint32_t>(sizes[i] >> 32));
      if (end == _items.size()) out->close();
    });
  }
}

}  // namespace

std::vector<dl::Entry> one_record_per_ray(const dl::Index& index, const DatabaseHeader& header) {
  const std::size_t n_directions = header.directions.size();
  std::vector<dl::Entry> records(header.sets.active.size() * n_directions, dl::Entry{-1, -1, -1, -1});
  for (const auto& entry : index.entries) {
    auto& slot =
        records[static_cast<std::size_t>(entry.active) * n_directions + static_cast<std::size_t>(entry.direction)];
    if (is_missing(slot)) slot = entry;
  }
  return records;
}

void write_packed(const std::filesystem::path& file, const DatabaseHeader& header, const dl::Index& index,
                  const std::vector<dl::Entry>& records, const PackingRanks& ranks,
                  const std::function<AtRest(std::int32_t point)>& at_rest) {
  const std::filesystem::path packing = file.string() + ".packing";
  try {
    Packing(header, index, records, ranks).write(packing, at_rest);
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
