#include "database_log.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>
#include <phynness/formats/ray_tasks.hpp>

namespace phynness::database_log {
namespace {

static_assert(std::endian::native == std::endian::little,
              "logs are little-endian; byte swaps for this host are not implemented");

constexpr std::size_t hash_bytes = 16;

class Bytes {
 public:
  template <class T>
  void put(const T& value) {
    put(&value, 1);
  }
  template <class T>
  void put(const T* values, std::size_t n) {
    const auto* p = reinterpret_cast<const unsigned char*>(values);
    _bytes.insert(_bytes.end(), p, p + n * sizeof(T));
  }
  void reserve(std::size_t n) { _bytes.reserve(n); }
  const std::vector<unsigned char>& get() const { return _bytes; }
  std::vector<unsigned char> take() { return std::move(_bytes); }

 private:
  std::vector<unsigned char> _bytes;
};

template <class T>
std::vector<T> take(const unsigned char*& from, std::size_t n) {
  std::vector<T> values(n);
  if (n > 0) std::memcpy(values.data(), from, n * sizeof(T));
  from += n * sizeof(T);
  return values;
}

std::uint64_t checksum(const unsigned char* bytes, std::size_t n) {
  Fnv1a64 hash;
  hash.add(bytes, n);
  return hash.value();
}

}  // namespace

Layout::Layout(const DatabaseHeader& header)
    : n_active(static_cast<std::int32_t>(header.sets.active.size())),
      n_directions(static_cast<std::int32_t>(header.directions.size())),
      n_increments(static_cast<std::int32_t>(header.magnitudes_m.size())),
      n_output(static_cast<std::int32_t>(header.sets.output.size())),
      tangents(header.tangents),
      float64(header.float64),
      fields(header.fields) {}

std::size_t Layout::payload_bytes() const {
  const std::size_t per_increment =
      sizeof(std::int8_t) + (3 + 1 + (tangents ? 9 : 0) + 2) * sizeof(double) + 3 * sizeof(std::int32_t) +
      3 * static_cast<std::size_t>(n_output) * (float64 ? sizeof(double) : sizeof(float)) +
      fields.size() * static_cast<std::size_t>(n_output) * sizeof(float);
  const std::size_t end = sizeof(std::int8_t) + 3 * sizeof(double);
  return 2 * sizeof(std::int32_t) + end + static_cast<std::size_t>(n_increments) * per_increment;
}

std::uint64_t record_checksum(const std::vector<unsigned char>& opening, const unsigned char* bytes, std::size_t n) {
  Fnv1a64 hash;
  hash.add(opening.data(), opening.size());
  hash.add(bytes, n);
  return hash.value();
}

std::filesystem::path folder(const std::filesystem::path& file) { return file.string() + ".log"; }

std::vector<unsigned char> encode_opening(const DatabaseHeader& header) {
  const Layout layout(header);
  Bytes bytes;
  bytes.put(log_magic.data(), log_magic.size());
  for (std::string hash : {header.physics_hash, header.mesh_hash}) {
    hash.resize(hash_bytes, ' ');
    bytes.put(hash.data(), hash_bytes);
  }
  std::int32_t stored = layout.tangents ? 1 : 0;
  for (const auto field : layout.fields) stored |= 2 << static_cast<int>(field);
  for (std::int32_t n : {layout.n_active, layout.n_directions, layout.n_increments, layout.n_output, stored,
                         std::int32_t{layout.float64}})
    bytes.put(n);
  bytes.put(checksum(bytes.get().data(), bytes.get().size()));
  return bytes.take();
}

std::vector<unsigned char> encode(const Ray& ray, const Layout& layout, const std::vector<unsigned char>& opening) {
  const auto n = static_cast<std::size_t>(layout.n_increments);
  const bool fits =
      ray.active >= 0 && ray.active < layout.n_active && ray.direction >= 0 && ray.direction < layout.n_directions &&
      ray.status.size() == n && ray.force.size() == 3 * n && ray.energy.size() == n &&
      ray.tangent.size() == (layout.tangents ? 9 * n : 0) && ray.negative_pivots.size() == n &&
      ray.iterations.size() == n && ray.cutbacks.size() == n && ray.min_jacobian.size() == n &&
      ray.seconds.size() == n && ray.displacement.size() == 3 * n * static_cast<std::size_t>(layout.n_output) &&
      ray.fields.size() == layout.fields.size() &&
      std::all_of(ray.fields.begin(), ray.fields.end(),
                  [&](const auto& values) { return values.size() == n * static_cast<std::size_t>(layout.n_output); });
  if (!fits)
    throw failure("the arrays of a ray do not have the sizes of its database",
                  "active " + std::to_string(ray.active) + ", direction " + std::to_string(ray.direction),
                  "this is a defect of the program; please report it");
  Bytes bytes;
  bytes.reserve(layout.record_bytes());
  bytes.put(record_magic.data(), record_magic.size());
  bytes.put(static_cast<std::uint32_t>(layout.payload_bytes()));
  bytes.put(ray.active);
  bytes.put(ray.direction);
  bytes.put(ray.end.reason);
  for (const double value : {ray.end.depth_m, ray.end.fold_depth_m, ray.end.energy_lost_J}) bytes.put(value);
  bytes.put(ray.status.data(), n);
  for (const auto* values : {&ray.force, &ray.energy, &ray.tangent}) bytes.put(values->data(), values->size());
  for (const auto* values : {&ray.negative_pivots, &ray.iterations, &ray.cutbacks}) bytes.put(values->data(), n);
  for (const auto* values : {&ray.min_jacobian, &ray.seconds}) bytes.put(values->data(), n);
  if (layout.float64) {
    bytes.put(ray.displacement.data(), ray.displacement.size());
  } else {
    const std::vector<float> rounded(ray.displacement.begin(), ray.displacement.end());
    bytes.put(rounded.data(), rounded.size());
  }
  for (const auto& values : ray.fields) {
    const std::vector<float> rounded(values.begin(), values.end());
    bytes.put(rounded.data(), rounded.size());
  }
  bytes.put(record_checksum(opening, bytes.get().data(), bytes.get().size()));
  return bytes.take();
}

Ray decode(const unsigned char* payload, const Layout& layout) {
  const auto n = static_cast<std::size_t>(layout.n_increments);
  Ray ray;
  ray.active = take<std::int32_t>(payload, 1)[0];
  ray.direction = take<std::int32_t>(payload, 1)[0];
  ray.end.reason = take<EndReason>(payload, 1)[0];
  for (double* value : {&ray.end.depth_m, &ray.end.fold_depth_m, &ray.end.energy_lost_J})
    *value = take<double>(payload, 1)[0];
  ray.status = take<Status>(payload, n);
  ray.force = take<double>(payload, 3 * n);
  ray.energy = take<double>(payload, n);
  ray.tangent = take<double>(payload, layout.tangents ? 9 * n : 0);
  ray.negative_pivots = take<std::int32_t>(payload, n);
  ray.iterations = take<std::int32_t>(payload, n);
  ray.cutbacks = take<std::int32_t>(payload, n);
  ray.min_jacobian = take<double>(payload, n);
  ray.seconds = take<double>(payload, n);
  const std::size_t displacements = 3 * n * static_cast<std::size_t>(layout.n_output);
  if (layout.float64) {
    ray.displacement = take<double>(payload, displacements);
  } else {
    const auto rounded = take<float>(payload, displacements);
    ray.displacement.assign(rounded.begin(), rounded.end());
  }
  for (std::size_t f = 0; f < layout.fields.size(); ++f) {
    const auto rounded = take<float>(payload, n * static_cast<std::size_t>(layout.n_output));
    ray.fields.emplace_back(rounded.begin(), rounded.end());
  }
  return ray;
}

}  // namespace phynness::database_log

double phynness::record_bytes(const DatabaseHeader& header) {
  return static_cast<double>(database_log::Layout(header).record_bytes());
}
