// A small valid database as a file to be changed: a block with every kind of content.
#pragma once

#include <phynness/formats/database.hpp>

namespace phynness::fuzz {

/// 8 nodes, 6 cells, 2 active nodes, 6 directions, 2 increments; with fields, or without.
DatabaseHeader small_header(bool rich);

/// Responses of a spring at each node that stiffens a little, so that every family can be fitted.
Ray small_ray(const DatabaseHeader& header, std::int32_t active, std::int32_t direction);

/// Writes the database; `complete`: packed, else with its rays in one log.
void write_small_database(const std::filesystem::path& file, bool rich, bool complete);

}  // namespace phynness::fuzz
