// Logs of an unfinished database. Each record is one ray with its length and a checksum (formats/database.md).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <phynness/formats/database.hpp>
#include <vector>

#include "ray_columns.hpp"

namespace phynness::database_log {

/// The last character is the version of the format.
inline constexpr std::array<char, 8> log_magic{'P', 'H', 'Y', 'N', 'L', 'O', 'G', '0' + format_version};
inline constexpr std::array<char, 4> record_magic{'P', 'R', 'A', 'Y'};
/// Bytes of magic and length before a payload; the checksum follows the payload.
inline constexpr std::size_t prefix_bytes = record_magic.size() + sizeof(std::uint32_t);
inline constexpr std::size_t checksum_bytes = sizeof(std::uint64_t);

/// A number from the bytes of a log.
template <class T>
T value_at(const unsigned char* bytes) {
  static_assert(std::endian::native == std::endian::little,
                "databases and logs are little-endian; byte swaps for this host are not implemented");
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// What is the same for every record of a database.
struct Layout {
  explicit Layout(const DatabaseHeader& header);
  std::int32_t n_active, n_directions;
  std::vector<StoredColumn> columns;  ///< in their order in a record
  std::size_t payload_bytes = 0;
  std::size_t record_bytes() const { return prefix_bytes + payload_bytes + checksum_bytes; }
};

/// The folder with the logs of a database file.
std::filesystem::path folder(const std::filesystem::path& file);

/// The first bytes of a log, which identify the physics and mesh of its rays.
std::vector<unsigned char> encode_opening(const DatabaseHeader& header);
/// One record: magic, length, payload, checksum.
/// @param opening  first bytes of the log to which the record is appended
/// @throws Error (failure) if the ray's arrays do not have the database's sizes
std::vector<unsigned char> encode(const Ray& ray, const Layout& layout, const std::vector<unsigned char>& opening);
/// Checksum of the opening and the record, so that a record can be assigned to its physics and mesh even if the opening
/// of its log is damaged.
std::uint64_t record_checksum(const std::vector<unsigned char>& opening, const unsigned char* bytes, std::size_t n);
/// @param of_output_nodes  if given, the ray has these columns only, or all others
/// @pre `payload` has layout.payload_bytes bytes
Ray decode(const unsigned char* payload, const Layout& layout, std::optional<bool> of_output_nodes);

}  // namespace phynness::database_log

namespace phynness {

// database_folder.cpp

/// @throws Error (input) unless the folder of `file` exists and is writable
void check_folder_of(const std::filesystem::path& file);
/// Creates FILE.log/ if it does not exist. @throws Error (failure)
void make_log_folder(const std::filesystem::path& file);
/// Removes the logs in FILE.log/, and the folder if nothing else is in it: what others put there is theirs.
void remove_logs(const std::filesystem::path& file);

}  // namespace phynness
