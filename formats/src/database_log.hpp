// The logs of an unfinished database: one ray per record, checked by length and checksum
// (formats/database.md).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

#include "durable_file.hpp"

namespace phynness::database_log {

inline constexpr std::array<char, 8> log_magic{'P', 'H', 'Y', 'N', 'L', 'O', 'G', '2'};
inline constexpr std::array<char, 4> record_magic{'P', 'R', 'A', 'Y'};
/// Magic and length before a payload, checksum after it.
inline constexpr std::size_t prefix_bytes = record_magic.size() + sizeof(std::uint32_t);
inline constexpr std::size_t checksum_bytes = sizeof(std::uint64_t);

/// Sizes that every record of a database shares.
struct Layout {
  explicit Layout(const DatabaseHeader& header);
  std::int32_t n_active, n_directions, n_increments, n_output;
  bool tangents, float64;
  std::vector<Field> fields;
  std::size_t payload_bytes() const;
  std::size_t record_bytes() const { return prefix_bytes + payload_bytes() + checksum_bytes; }
};

/// The folder of logs that belongs to a database file.
std::filesystem::path folder(const std::filesystem::path& file);

/// The bytes that open a log: which physics and mesh its rays belong to.
std::vector<unsigned char> encode_opening(const DatabaseHeader& header);
/// One record: magic, length, payload, checksum.
/// @param opening  of the log that the record goes to
/// @throws Error (failure) if the ray's arrays do not have the database's sizes
std::vector<unsigned char> encode(const Ray& ray, const Layout& layout, const std::vector<unsigned char>& opening);
/// Over the opening and the record, so that a record says which work it belongs to even where the opening of
/// its log is damaged.
std::uint64_t record_checksum(const std::vector<unsigned char>& opening, const unsigned char* bytes, std::size_t n);
/// @pre `payload` has layout.payload_bytes() bytes
Ray decode(const unsigned char* payload, const Layout& layout);

}  // namespace phynness::database_log
