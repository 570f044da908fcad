// Shards into one database.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// A ray that no shard holds.
struct MissingRay {
  std::int32_t node = 0;       ///< of the mesh
  std::int32_t direction = 0;  ///< index into the directions
  std::optional<Shard> owner;  ///< who is to solve it; empty if no file that was merged is a shard
};

struct MergeReport {
  std::int64_t rays_total = 0;  ///< of those that are solved, not mirrored
  std::vector<LogDamage> damage;
  std::vector<MissingRay> missing;  ///< if there are any, nothing was written
};

/// Packs the rays of unfinished databases of one and the same work, usually its shards, into `output`, and
/// leaves them as they are. The result is the file that one run over all rays would have written. A ray that
/// several hold is taken from the first.
/// @pre shards is not empty
/// @throws Error (input) if `output` exists, if a shard is unreadable, finished, still being computed or of
/// another physics or mesh than the first, saying what differs; (failure) if writing fails
MergeReport merge_shards(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& output);

}  // namespace phynness
