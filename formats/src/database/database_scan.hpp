// Index of the rays in the logs of unfinished databases.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <phynness/formats/database.hpp>
#include <vector>

#include "database_log.hpp"

namespace phynness::database_log {

/// A complete record in a log.
struct Entry {
  std::int32_t active, direction;
  std::int32_t log;     ///< index in Index::logs
  std::int64_t offset;  ///< of the payload
};
struct Index {
  std::vector<std::filesystem::path> logs;  ///< sorted by name
  std::vector<Entry> entries;               ///< in the order of the logs
  std::vector<LogDamage> damage;            ///< of the logs that this process has read
};

/// Sorted names of the logs in the folder of a database.
std::vector<std::filesystem::path> logs_of(const std::filesystem::path& file);

/// Checks every record of every log of the database `file`. Torn and corrupted records are skipped, and so are logs
/// whose opening is damaged.
/// @param ranks  share the logs, and all get all entries
/// @throws Error (input) if a log belongs to another physics or mesh than `header`
Index scan(const std::filesystem::path& file, const DatabaseHeader& header, const PackingRanks& ranks = {});

/// Reads rays from any number of logs and keeps only a few of them open.
class RayReader {
 public:
  RayReader(const Index& index, const DatabaseHeader& header)
      : _index(index), _layout(header), _payload(_layout.payload_bytes) {}
  /// @param of_output_nodes  if given, the ray has these columns only, or all others
  /// @throws Error (failure) if the log has become shorter since it was scanned
  Ray read(const Entry& entry, std::optional<bool> of_output_nodes = {});

 private:
  const Index& _index;
  Layout _layout;
  std::vector<unsigned char> _payload;
  std::map<std::int32_t, std::ifstream> _open;
};

}  // namespace phynness::database_log
