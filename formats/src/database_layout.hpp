// Layout of a database file; formats/database.md describes it.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

#include "hdf5_file.hpp"

namespace phynness::database_layout {

inline constexpr std::int32_t format_version = 1;
/// What was added to the version without a change of the rest. 1: ends of rays. Absent: 0.
inline constexpr std::int32_t format_minor = 1;

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
inline constexpr const char* end_reason = "/responses/end_reason";
inline constexpr const char* end_depth = "/responses/end_depth";
inline constexpr const char* fold_depth = "/responses/fold_depth";
inline constexpr const char* energy_lost = "/responses/energy_lost";
}  // namespace path

/// Path of a field's dataset.
std::string path_of(Field field);

/// Writes all datasets and attributes except the rays to a new file.
void write_header(hdf5::File& file, const DatabaseHeader& header, bool complete);
/// @throws Error (input) if the file is not a database, of another version, or damaged
DatabaseHeader read_header(const hdf5::File& file);
bool read_complete(const hdf5::File& file);
/// True if the file tells where its rays end.
bool records_ends(const hdf5::File& file);

/// Creates the datasets under /responses and chooses the number of active nodes in a chunk of the small ones.
void create_responses(hdf5::File& file, const DatabaseHeader& header);
hsize_t nodes_per_chunk(const DatabaseHeader& header);

}  // namespace phynness::database_layout
