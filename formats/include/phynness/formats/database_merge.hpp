// Merging of shards into one database.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

/// A ray that is in no shard.
struct MissingRay {
  std::int32_t node = 0;       ///< node number of the mesh
  std::int32_t direction = 0;  ///< index of the direction
  std::optional<Shard> owner;  ///< the shard to which it belongs; empty if no merged file is a shard
};

struct MergeReport {
  std::int64_t rays_total = 0;
  std::vector<LogDamage> damage;
  std::vector<MissingRay> missing;  ///< if not empty, no database was written
};

/// Packs the rays of unfinished databases of the same scene, usually its shards, into `output`. The shards are not
/// changed. The result is the file that a single run over all rays would have written. A ray that is in several shards
/// is taken from the first.
/// @pre shards is not empty
/// @throws Error (input) if `output` exists, or if a shard is unreadable, finished, still being computed, or of another
/// physics or mesh than the first (the message lists the differences); (failure) if writing fails
MergeReport merge_shards(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& output);

}  // namespace phynness
