// From logs to the finished file.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <vector>

#include "database_scan.hpp"

namespace phynness {

inline bool is_missing(const database_log::Entry& entry) { return entry.log < 0; }

/// For each ray, [active][direction] flattened, its first whole record, or one that is_missing().
std::vector<database_log::Entry> one_record_per_ray(const database_log::Index& index,
                                                    const DatabaseHeader& header);

/// Writes FILE.packing, forces it to the disk and renames it to FILE; nothing stays behind if that fails.
/// @pre no record is missing
/// @throws Error
void write_packed(const std::filesystem::path& file, const DatabaseHeader& header,
                  const database_log::Index& index, const std::vector<database_log::Entry>& records);

}  // namespace phynness
