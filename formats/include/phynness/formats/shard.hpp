// A part of a database's rays, solved by a process of its own that talks to no other.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace phynness {

/// Shard `index` of `count`, counted from 0. Which rays it owns depends on nothing but these two numbers and
/// the header of the database, so every process knows it without asking.
struct Shard {
  std::int32_t index = 0, count = 1;

  bool operator==(const Shard&) const = default;
  /// "3/8"
  std::string str() const;
};

/// Reads "3/8".
/// @throws Error (input) unless it is i/n with 0 <= i < n
Shard parse_shard(const std::string& text);

/// For each ray, [active][direction] flattened, the index of the shard that owns it; -1 if it is not solved.
/// Runs of directions of one node stay together, as touching a node costs a factorization. The first runs of
/// all nodes go round the shards, then the second runs, and so on, runs without a ray to solve passed over:
/// shards differ by at most one run where all rays are solved, and each gets all directions, of nodes all
/// over the body. A shard has about 16 runs, if there are rays enough.
/// @param is_solved  n_active x n_directions flags: MirroredRays::solved()
/// @pre n_directions > 0, count > 0
std::vector<std::int32_t> shards_of_rays(const std::vector<char>& is_solved, std::size_t n_directions,
                                         std::int32_t count);

/// Where a shard of `database` is written: database.h5 -> database.shard-3-of-8.h5.
std::filesystem::path shard_file(const std::filesystem::path& database, const Shard& shard);
/// The reverse; `file` itself if it is not named like that.
std::filesystem::path database_of(const std::filesystem::path& file, const Shard& shard);

}  // namespace phynness
