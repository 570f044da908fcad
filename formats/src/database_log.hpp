// The logs of an unfinished database: one ray per record, checked by length and checksum
// (formats/database.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

#include "durable_file.hpp"

namespace phynness::database_log {

/// Sizes that every record of a database shares.
struct Layout {
  explicit Layout(const DatabaseHeader& header);
  std::int32_t n_active, n_directions, n_increments, n_output;
  bool tangents, float64;
  std::size_t payload_bytes() const;
};

/// The folder of logs that belongs to a database file.
std::filesystem::path folder(const std::filesystem::path& file);

/// The bytes that open a log: which physics and mesh its rays belong to.
std::vector<unsigned char> encode_opening(const DatabaseHeader& header);
/// One record: magic, length, payload, checksum.
/// @throws Error (failure) if the ray's arrays do not have the database's sizes
std::vector<unsigned char> encode(const Ray& ray, const Layout& layout);
/// @pre `payload` has layout.payload_bytes() bytes
Ray decode(const unsigned char* payload, const Layout& layout);

/// A whole record in a log.
struct Entry {
  std::int32_t active, direction;
  std::int32_t log;     ///< index into Index::logs
  std::int64_t offset;  ///< of the payload
};
struct Index {
  std::vector<std::filesystem::path> logs;  ///< sorted by name
  std::vector<Entry> entries;               ///< in the order of the logs
  std::vector<LogDamage> damage;
};
/// Checks every record of every log; a log counts up to its first record that is torn or corrupted.
/// @throws Error (input) if a log belongs to another physics or mesh
Index scan(const std::filesystem::path& file, const DatabaseHeader& header);

}  // namespace phynness::database_log
