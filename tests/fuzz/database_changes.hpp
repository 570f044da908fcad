// Changes to an HDF5 file by HDF5 itself, so that the result is valid HDF5 with wrong content.
#pragma once

#include <filesystem>

#include "fuzz_target.hpp"

namespace phynness::fuzz {

/// Makes the changes that the script asks for, up to its end. What HDF5 refuses to do is left undone.
void change_objects(const std::filesystem::path& file, Script& script);

/// Makes the attribute mesh_hash that of the mesh in the file, if there is one.
void seal_mesh(const std::filesystem::path& file);

/// Gives every record of a log the checksum that belongs to it, whatever stood there.
/// @param record_bytes  of a whole record
void seal_log(std::vector<std::uint8_t>& log, std::size_t record_bytes);

}  // namespace phynness::fuzz
