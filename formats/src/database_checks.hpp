// Checks of the header of a database: of its numbers, when it is read and when it is written, because other code uses
// them as indices, counts and divisors; and whether the present run can continue it.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <string>
#include <vector>

namespace phynness {

/// @param where  start of the message: "the database FILE"
/// @throws Error (input) with the first invalid dataset, entry and value
void check_header(const DatabaseHeader& header, const std::string& where);

/// Largest plausible displacement [m] of a point of the body: a hundred diagonals of its bounding box.
double largest_displacement(const Mesh& mesh);

/// What two studies do not have in common.
struct Difference {
  std::string what;    ///< "other active nodes", "another physics"
  std::string values;  ///< of both; of the physics one line for each key
  bool of_rays;        ///< no ray of one is a ray of the other; false: others are chosen, or others are mirror images
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
  DatabaseHeader stored;  ///< of the file
};
/// @throws Error (input) with all reasons if no ray of the file is one of `wanted`
Arrangement arranged(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file);

}  // namespace phynness
