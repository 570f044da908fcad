// Layout of a database file; formats/database.md describes it.
#pragma once

#include <phynness/formats/database.hpp>

#include "hdf5_file.hpp"
#include "ray_columns.hpp"

namespace phynness::database_layout {

namespace path {
inline constexpr const char* nodes = "/mesh/nodes";
inline constexpr const char* cells = "/mesh/cells";
inline constexpr const char* surface = "/mesh/surface";
inline constexpr const char* groups = "/mesh/groups";
inline constexpr const char* regions = "/mesh/regions";
inline constexpr const char* fixed = "/sets/fixed";
inline constexpr const char* active = "/sets/active";
inline constexpr const char* output = "/sets/output";
inline constexpr const char* tools = "/tools";
inline constexpr const char* rest = "/rest";
inline constexpr const char* rest_points = "/rest/points";
inline constexpr const char* rest_stiffness = "/rest/stiffness";
inline constexpr const char* rest_displacement = "/rest/displacement";
inline constexpr const char* directions = "/directions";
inline constexpr const char* magnitudes = "/magnitudes";
inline constexpr const char* scene = "/scene";
}  // namespace path

/// More than write_header() writes.
std::uint64_t header_bytes(const DatabaseHeader& header);
/// Writes all datasets and attributes except the rays to a new file.
void write_header(hdf5::File& file, const DatabaseHeader& header, bool complete);
/// @throws Error (input) if the file is not a database, of another version, or damaged
DatabaseHeader read_header(const hdf5::File& file);
bool read_complete(const hdf5::File& file);

/// Creates the datasets under /responses. A chunk of those without an axis of output nodes has several active nodes.
void create_responses(hdf5::File& file, const DatabaseHeader& header);
/// Creates and writes the responses at rest, if there are points for them.
void write_at_rest(hdf5::File& file, const DatabaseHeader& header,
                   const std::function<AtRest(std::int32_t point)>& at_rest);
hsize_t nodes_per_chunk(const DatabaseHeader& header);
/// Shape of the chunks of a column; empty if it has no values.
hdf5::Shape chunk_shape(const StoredColumn& column, const DatabaseHeader& header);

}  // namespace phynness::database_layout
