#include "database_log.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <phynness/formats/error.hpp>
#include <phynness/formats/hash.hpp>

namespace phynness::database_log {
namespace {

static_assert(std::endian::native == std::endian::little,
              "logs are little-endian; this host needs byte swaps");

constexpr char log_magic[8] = {'P', 'H', 'Y', 'N', 'L', 'O', 'G', '1'};
constexpr std::uint32_t record_magic = 0x59415250;  // "PRAY"
constexpr std::size_t hash_bytes = 16;
constexpr std::size_t prefix_bytes = 2 * sizeof(std::uint32_t);
constexpr std::size_t checksum_bytes = sizeof(std::uint64_t);

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

template <class T>
T value_at(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// One log, read record by record.
void scan_log(const std::filesystem::path& path, std::int32_t number,
              const std::vector<unsigned char>& opening, const Layout& layout, Index& index) {
  const Descriptor file = open_for_reading(path);
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path));
  std::int64_t at = 0;
  const auto damaged = [&](const std::string& reason) { index.damage.push_back({path, reason, size - at}); };

  std::vector<unsigned char> found(opening.size());
  const auto got = read_at(file, path, 0, found.data(), found.size());
  if (got < found.size()) {
    if (size > 0) damaged("torn opening");
    return;
  }
  const std::size_t body = found.size() - checksum_bytes;
  if (value_at<std::uint64_t>(found.data() + body) != checksum(found.data(), body))
    return damaged("corrupted opening");
  if (found != opening)
    throw input_error("the log belongs to another scene or mesh than the database", path.string(),
                      "restore the scene that it was made with, or delete this log to solve its rays again");
  at = static_cast<std::int64_t>(opening.size());

  const std::size_t payload = layout.payload_bytes();
  std::vector<unsigned char> record(prefix_bytes + payload + checksum_bytes);
  while (at < size) {
    if (read_at(file, path, at, record.data(), record.size()) < record.size()) return damaged("torn record");
    if (value_at<std::uint32_t>(record.data()) != record_magic ||
        value_at<std::uint32_t>(record.data() + sizeof(std::uint32_t)) != payload ||
        value_at<std::uint64_t>(record.data() + prefix_bytes + payload) !=
            checksum(record.data(), prefix_bytes + payload))
      return damaged("corrupted record");
    const auto active = value_at<std::int32_t>(record.data() + prefix_bytes);
    const auto direction = value_at<std::int32_t>(record.data() + prefix_bytes + sizeof(std::int32_t));
    if (active < 0 || active >= layout.n_active || direction < 0 || direction >= layout.n_directions)
      return damaged("record of a ray that the database does not have");
    index.entries.push_back({active, direction, number, at + static_cast<std::int64_t>(prefix_bytes)});
    at += static_cast<std::int64_t>(record.size());
  }
}

}  // namespace

Layout::Layout(const DatabaseHeader& header)
    : n_active(static_cast<std::int32_t>(header.sets.active.size())),
      n_directions(static_cast<std::int32_t>(header.directions.size())),
      n_increments(static_cast<std::int32_t>(header.magnitudes_m.size())),
      n_output(static_cast<std::int32_t>(header.sets.output.size())),
      tangents(header.tangents),
      float64(header.float64) {}

std::size_t Layout::payload_bytes() const {
  const std::size_t per_increment =
      sizeof(std::int8_t) + (3 + 1 + (tangents ? 9 : 0) + 2) * sizeof(double) + 3 * sizeof(std::int32_t) +
      3 * static_cast<std::size_t>(n_output) * (float64 ? sizeof(double) : sizeof(float));
  return 2 * sizeof(std::int32_t) + static_cast<std::size_t>(n_increments) * per_increment;
}

std::filesystem::path folder(const std::filesystem::path& file) { return file.string() + ".log"; }

std::vector<unsigned char> encode_opening(const DatabaseHeader& header) {
  const Layout layout(header);
  Bytes bytes;
  bytes.put(log_magic, sizeof log_magic);
  for (std::string hash : {header.physics_hash, header.mesh_hash}) {
    hash.resize(hash_bytes, ' ');
    bytes.put(hash.data(), hash_bytes);
  }
  for (std::int32_t n : {layout.n_active, layout.n_directions, layout.n_increments, layout.n_output,
                         std::int32_t{layout.tangents}, std::int32_t{layout.float64}})
    bytes.put(n);
  bytes.put(checksum(bytes.get().data(), bytes.get().size()));
  return bytes.take();
}

std::vector<unsigned char> encode(const Ray& ray, const Layout& layout) {
  const auto n = static_cast<std::size_t>(layout.n_increments);
  const bool fits = ray.active >= 0 && ray.active < layout.n_active && ray.direction >= 0 &&
                    ray.direction < layout.n_directions && ray.status.size() == n &&
                    ray.force.size() == 3 * n && ray.energy.size() == n &&
                    ray.tangent.size() == (layout.tangents ? 9 * n : 0) && ray.negative_pivots.size() == n &&
                    ray.iterations.size() == n && ray.cutbacks.size() == n && ray.min_jacobian.size() == n &&
                    ray.seconds.size() == n &&
                    ray.displacement.size() == 3 * n * static_cast<std::size_t>(layout.n_output);
  if (!fits)
    throw failure("a ray does not fit its database",
                  "active " + std::to_string(ray.active) + ", direction " + std::to_string(ray.direction),
                  "this is a defect of the program: report it");
  Bytes bytes;
  bytes.reserve(prefix_bytes + layout.payload_bytes() + checksum_bytes);
  bytes.put(record_magic);
  bytes.put(static_cast<std::uint32_t>(layout.payload_bytes()));
  bytes.put(ray.active);
  bytes.put(ray.direction);
  bytes.put(ray.status.data(), n);
  for (const auto* values : {&ray.force, &ray.energy, &ray.tangent})
    bytes.put(values->data(), values->size());
  for (const auto* values : {&ray.negative_pivots, &ray.iterations, &ray.cutbacks})
    bytes.put(values->data(), n);
  for (const auto* values : {&ray.min_jacobian, &ray.seconds}) bytes.put(values->data(), n);
  if (layout.float64) {
    bytes.put(ray.displacement.data(), ray.displacement.size());
  } else {
    const std::vector<float> rounded(ray.displacement.begin(), ray.displacement.end());
    bytes.put(rounded.data(), rounded.size());
  }
  bytes.put(checksum(bytes.get().data(), bytes.get().size()));
  return bytes.take();
}

Ray decode(const unsigned char* payload, const Layout& layout) {
  const auto n = static_cast<std::size_t>(layout.n_increments);
  Ray ray;
  ray.active = take<std::int32_t>(payload, 1)[0];
  ray.direction = take<std::int32_t>(payload, 1)[0];
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
  return ray;
}

Index scan(const std::filesystem::path& file, const DatabaseHeader& header) {
  Index index;
  const auto dir = folder(file);
  std::error_code code;
  if (!std::filesystem::is_directory(dir, code)) return index;
  for (const auto& item : std::filesystem::directory_iterator(dir))
    if (item.is_regular_file() && item.path().filename().string().starts_with("rank-"))
      index.logs.push_back(item.path());
  std::sort(index.logs.begin(), index.logs.end());
  const auto opening = encode_opening(header);
  const Layout layout(header);
  for (std::size_t i = 0; i < index.logs.size(); ++i)
    scan_log(index.logs[i], static_cast<std::int32_t>(i), opening, layout, index);
  return index;
}

}  // namespace phynness::database_log
