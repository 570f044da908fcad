// Whether a database on disk may be continued by the run at hand.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>

namespace phynness {

/// @param other  where `wanted` comes from, for messages: "500 in the file, 600 now"
/// @throws Error (input) unless both have the same physics, mesh, node sets, directions, increments and
/// stored arrays; a difference of physics is listed key by key.
void refuse_other_work(
    const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
    const std::string& other = "now",
    const std::string& remedy = "restore what the database was begun with, or write to another file");

}  // namespace phynness
