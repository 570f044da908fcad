// Shards: parts of the rays of a database that are solved by independent processes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace phynness {

/// Shard `index` of `count`, starting with 0. Its rays depend only on these two numbers and the header of the database,
/// so that processes need no communication.
struct Shard {
  std::int32_t index = 0, count = 1;

  bool operator==(const Shard&) const = default;
  /// "3/8"
  std::string str() const;
};

/// Parses "3/8".
/// @throws Error (input) unless it is i/n with 0 <= i < n
Shard parse_shard(const std::string& text);

/// For each ray, [active][direction] flattened, the index of its shard. The directions of a node are divided into runs,
/// which stay together because each change of the node costs a factorization. The first runs of all nodes are assigned
/// to the shards in turn, then the second runs, and so on. Shards differ by at most one run, and each has all
/// directions and nodes from the whole body. A shard has about 16 runs if there are enough rays.
/// @pre n_directions > 0, count > 0
std::vector<std::int32_t> shards_of_rays(std::size_t n_active, std::size_t n_directions, std::int32_t count);

/// The file of a shard of `database`: database.h5 -> database.shard-3-of-8.h5.
std::filesystem::path shard_file(const std::filesystem::path& database, const Shard& shard);
/// The inverse of shard_file; `file` itself if it does not have such a name.
std::filesystem::path database_of(const std::filesystem::path& file, const Shard& shard);

}  // namespace phynness
