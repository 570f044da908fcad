// Check whether a database on disk can be continued by the present run.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>

namespace phynness {

/// @param other  origin of `wanted` in messages, such as "now" in "500 in the file, 600 now"
/// @throws Error (input) unless both have the same physics, mesh, node sets, directions, increments and stored arrays.
/// Differences of the physics are listed key by key.
void refuse_other_work(
    const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
    const std::string& other = "now",
    const std::string& remedy = "use the scene with which the database was begun, or write to another file");

}  // namespace phynness
