// Predicted size of a database and time of packing, measured with a few rays.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <vector>

namespace phynness {

struct PackingTrial {
  double header_bytes = 0;                          ///< size of the file of the whole scene without its rays
  double record_bytes = 0;                          ///< of one ray in a log
  double packed_bytes_per_ray = 0;                  ///< of one ray in the finished file, compressed
  double append_s_per_ray = 0, pack_s_per_ray = 0;  ///< CPU time
};

/// Writes, packs and removes a database of these rays by the functions that also write and pack the whole database.
/// @param header  of the whole scene
/// @param rays    solved rays in the order of the database, at least one
/// @param folder  a new folder is made in this folder and removed
/// @throws Error
PackingTrial try_packing(const DatabaseHeader& header, const std::vector<Ray>& rays,
                         const std::filesystem::path& folder);

}  // namespace phynness
