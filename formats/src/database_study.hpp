// How the study of a database relates to another one: what differs, and which rays both have.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

namespace phynness {

/// What two studies do not have in common.
struct Difference {
  std::string what;    ///< "other active nodes", "another physics"
  std::string values;  ///< of both; of the physics one line for each key
  bool of_rays;        ///< no ray of one is a ray of the other; false: others are chosen
};
/// Compares physics, mesh, node sets, directions, increments and stored arrays themselves, not only their hashes.
/// @param other  origin of `wanted` in messages, such as "now" in "500 in the file, 600 now"
std::vector<Difference> differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted,
                                    const std::string& other = "now");

/// @throws Error (input) with the first difference
void refuse_other_work(
    const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file,
    const std::string& other = "now",
    const std::string& remedy = "use the scene with which the database was begun, or write to another file");

/// Where a study finds its rays in the database of another one: positions in the lists of that one, -1 if absent.
struct Arrangement {
  std::vector<std::int32_t> active, direction, output;
  double modulus_factor = 1;  ///< the study's moduli over those of the file
  DatabaseHeader stored;      ///< of the file
};
/// @throws Error (input) with all reasons if no ray of the file is one of `wanted`
Arrangement arranged(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file);

}  // namespace phynness
