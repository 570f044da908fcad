// Whether a database on disk may be continued by the run at hand.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>

namespace phynness {

/// @throws Error (input) unless both have the same physics, mesh, node sets, directions, increments and
/// stored arrays; a difference of physics is listed key by key.
void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted,
                       const std::filesystem::path& file);

}  // namespace phynness
