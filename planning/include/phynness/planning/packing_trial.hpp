// What a database will weigh and how long packing takes, tried with a few rays.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

struct PackingTrial {
  double header_bytes = 0;                          ///< what the whole scene's file costs once: all but the rays
  double record_bytes = 0;                          ///< of one ray in a log
  double packed_bytes_per_ray = 0;                  ///< of one ray in the finished file, compressed
  double append_s_per_ray = 0, pack_s_per_ray = 0;  ///< CPU time
};

/// Writes, packs and removes a database of these rays, with the code that does it for all.
/// @param header  of the whole scene
/// @param rays    solved ones, in the database's order; at least one
/// @param folder  where to work; a folder of its own is made in it and removed
/// @throws Error
PackingTrial try_packing(const DatabaseHeader& header, const std::vector<Ray>& rays,
                         const std::filesystem::path& folder);

}  // namespace phynness
