// What stands where in a database file; the table for people is formats/database.md.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

#include "hdf5_file.hpp"

namespace phynness::database_layout {

inline constexpr std::int32_t format_version = 1;

namespace path {
inline constexpr const char* nodes = "/mesh/nodes";
inline constexpr const char* cells = "/mesh/cells";
inline constexpr const char* surface = "/mesh/surface";
inline constexpr const char* groups = "/mesh/groups";
inline constexpr const char* fixed = "/sets/fixed";
inline constexpr const char* active = "/sets/active";
inline constexpr const char* output = "/sets/output";
inline constexpr const char* symmetry = "/symmetry";
inline constexpr const char* mirror_normal = "/symmetry/normal";
inline constexpr const char* mirror_image = "/symmetry/image";
inline constexpr const char* directions = "/directions";
inline constexpr const char* magnitudes = "/magnitudes";
inline constexpr const char* scene = "/scene";
inline constexpr const char* status = "/responses/status";
inline constexpr const char* force = "/responses/force";
inline constexpr const char* energy = "/responses/energy";
inline constexpr const char* displacement = "/responses/displacement";
inline constexpr const char* tangent = "/responses/tangent";
inline constexpr const char* negative_pivots = "/responses/negative_pivots";
inline constexpr const char* iterations = "/responses/iterations";
inline constexpr const char* cutbacks = "/responses/cutbacks";
inline constexpr const char* min_jacobian = "/responses/min_jacobian";
inline constexpr const char* seconds = "/responses/seconds";
inline constexpr const char* solved_as = "/responses/solved_as";
inline constexpr const char* fields = "/responses/fields";
}  // namespace path

/// Where a field's values are.
std::string path_of(Field field);

/// Everything but the rays, into a new file. `file_name` names a defect of the header in messages.
void write_header(hdf5::File& file, const DatabaseHeader& header, bool complete);
/// @throws Error if the file is no database, of another version, or damaged
DatabaseHeader read_header(const hdf5::File& file);
bool read_complete(const hdf5::File& file);

/// The datasets under /responses, and how many active nodes share a chunk of the small ones.
void create_responses(hdf5::File& file, const DatabaseHeader& header);
hsize_t nodes_per_chunk(const DatabaseHeader& header);

}  // namespace phynness::database_layout
