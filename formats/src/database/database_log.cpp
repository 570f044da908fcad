#include "database_log.hpp"

#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>

namespace phynness::database_log {
namespace {

constexpr std::size_t hash_bytes = 16;

using Bytes = std::vector<unsigned char>;
template <class T>
void put(Bytes& bytes, const T* values, std::size_t n) {
  const auto* p = reinterpret_cast<const unsigned char*>(values);
  bytes.insert(bytes.end(), p, p + n * sizeof(T));
}
template <class T>
void put(Bytes& bytes, const T& value) {
  put(bytes, &value, 1);
}

/// Reads the next values, which are float32 or of the type of `to`.
template <class T>
void take(const unsigned char*& from, bool float32, std::span<T> to) {
  const auto copy = [&from](auto* values, std::size_t bytes) {
    if (bytes > 0) std::memcpy(values, from, bytes);
    from += bytes;
  };
  if (!float32) return copy(to.data(), to.size_bytes());
  std::vector<float> rounded(to.size());
  copy(rounded.data(), rounded.size() * sizeof(float));
  std::transform(rounded.begin(), rounded.end(), to.begin(), [](float value) { return static_cast<T>(value); });
}

template <class T>
void put_column(Bytes& bytes, bool float32, std::span<const T> values) {
  if (!float32) return put(bytes, values.data(), values.size());
  for (const T value : values) put(bytes, static_cast<float>(value));
}

std::size_t bytes_of(const StoredColumn& column) {
  const auto size = [](auto member) { return sizeof(ValueOf<decltype(member)>); };
  return column.count * (column.float32 ? sizeof(float) : std::visit(size, column.member));
}

std::size_t number_of_values(const Ray& ray, const StoredColumn& column) {
  return std::visit([&](auto member) { return values_of(ray, member).size(); }, column.member);
}

}  // namespace

Layout::Layout(const DatabaseHeader& header)
    : n_active(static_cast<std::int32_t>(header.sets.active.size())),
      n_directions(static_cast<std::int32_t>(header.directions.size())),
      columns(columns_of(header)),
      payload_bytes(2 * sizeof(std::int32_t)) {
  std::stable_partition(columns.begin(), columns.end(), [](const auto& column) { return column.of == ColumnOf::ray; });
  for (const auto& column : columns) payload_bytes += bytes_of(column);
}

std::uint64_t record_checksum(const std::vector<unsigned char>& opening, const unsigned char* bytes, std::size_t n) {
  Fnv1a64 hash;
  hash.add(opening.data(), opening.size());
  hash.add(bytes, n);
  return hash.value();
}

std::filesystem::path folder(const std::filesystem::path& file) { return file.string() + ".log"; }

std::vector<unsigned char> encode_opening(const DatabaseHeader& header) {
  Bytes bytes;
  put(bytes, log_magic);
  for (std::string hash : {header.physics_hash, header.mesh_hash}) {
    hash.resize(hash_bytes, ' ');
    put(bytes, hash.data(), hash_bytes);
  }
  for (const std::size_t n :
       {header.sets.active.size(), header.directions.size(), header.magnitudes_m.size(), header.sets.output.size()})
    put(bytes, static_cast<std::int32_t>(n));
  std::int32_t stored = header.tangents ? 1 : 0;
  for (const auto field : header.fields) stored |= 2 << static_cast<int>(field);
  put(bytes, stored);
  put(bytes, std::int32_t{header.float64});
  put(bytes, record_checksum({}, bytes.data(), bytes.size()));
  return bytes;
}

std::vector<unsigned char> encode(const Ray& ray, const Layout& layout, const std::vector<unsigned char>& opening) {
  std::size_t n_fields = 0;
  bool fits =
      ray.active >= 0 && ray.active < layout.n_active && ray.direction >= 0 && ray.direction < layout.n_directions;
  for (const auto& column : layout.columns) {
    n_fields += std::holds_alternative<RayColumn::FieldIndex>(column.member);
    fits = fits && n_fields <= ray.fields.size() && number_of_values(ray, column) == column.count;
  }
  if (!fits)
    throw failure("the arrays of a ray do not have the sizes of its database",
                  "active " + std::to_string(ray.active) + ", direction " + std::to_string(ray.direction),
                  "this is a defect of the program; please report it");
  Bytes bytes;
  bytes.reserve(layout.record_bytes());
  put(bytes, record_magic);
  put(bytes, static_cast<std::uint32_t>(layout.payload_bytes));
  put(bytes, ray.active);
  put(bytes, ray.direction);
  for (const auto& column : layout.columns)
    std::visit(
        [&](auto member) { put_column<ValueOf<decltype(member)>>(bytes, column.float32, values_of(ray, member)); },
        column.member);
  put(bytes, record_checksum(opening, bytes.data(), bytes.size()));
  return bytes;
}

Ray decode(const unsigned char* payload, const Layout& layout, std::optional<bool> of_output_nodes) {
  Ray ray;
  for (std::int32_t* index : {&ray.active, &ray.direction}) take(payload, false, std::span(index, 1));
  for (const auto& column : layout.columns) {
    if (of_output_nodes && *of_output_nodes != (column.of == ColumnOf::output_node)) {
      payload += bytes_of(column);
      continue;
    }
    resize_values(ray, column, column.count);
    std::visit([&](auto member) { take(payload, column.float32, values_of(ray, member)); }, column.member);
  }
  return ray;
}

}  // namespace phynness::database_log

double phynness::record_bytes(const DatabaseHeader& header) {
  return static_cast<double>(database_log::Layout(header).record_bytes());
}
