// A part of a database's rays, solved by a process of its own that talks to no other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace phynness {

/// Shard `index` of `count`, counted from 0. Which rays it owns depends on nothing but these two numbers and
/// the sizes of the database, so every process knows it without asking.
struct Shard {
  std::int32_t index = 0, count = 1;

  bool operator==(const Shard&) const = default;
  /// "3/8"
  std::string str() const;
};

/// Reads "3/8".
/// @throws Error (input) unless it is i/n with 0 <= i < n
Shard parse_shard(const std::string& text);

/// The index of the shard that owns a ray. Runs of directions of one node stay together, as touching a node
/// costs a factorization. The first runs of all nodes go round the shards, then the second runs, and so on:
/// shards differ by at most one run, and each gets all directions, of nodes all over the body. A shard has
/// about 16 runs, if there are rays enough.
/// @pre 0 <= active < n_active, 0 <= direction < n_directions, count > 0
std::int32_t shard_of(std::int32_t active, std::int32_t direction, std::int32_t n_active,
                      std::int32_t n_directions, std::int32_t count);

/// Where a shard of `database` is written: database.h5 -> database.shard-3-of-8.h5.
std::filesystem::path shard_file(const std::filesystem::path& database, const Shard& shard);
/// The reverse; `file` itself if it is not named like that.
std::filesystem::path database_of(const std::filesystem::path& file, const Shard& shard);

}  // namespace phynness
