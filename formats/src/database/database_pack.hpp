// Conversion of logs to the finished file.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <vector>

#include "database_scan.hpp"

namespace phynness {

inline bool is_missing(const database_log::Entry& entry) { return entry.log < 0; }

/// For each ray, [active][direction] flattened, its first complete record, or an entry that is_missing().
std::vector<database_log::Entry> one_record_per_ray(const database_log::Index& index, const DatabaseHeader& header);

/// Writes FILE.packing, forces it to the disk and renames it to FILE. After a failure FILE.packing is removed. The
/// bytes do not depend on the number of ranks. Each compresses its share of the chunks, and rank 0 writes them.
/// @pre no record is missing; FILE is on a file system that all ranks share
/// @throws Error (failure)
void write_packed(const std::filesystem::path& file, const DatabaseHeader& header, const database_log::Index& index,
                  const std::vector<database_log::Entry>& records, const PackingRanks& ranks,
                  const std::function<AtRest(std::int32_t point)>& at_rest);

}  // namespace phynness
