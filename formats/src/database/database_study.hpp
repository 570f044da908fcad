// How the study of a database relates to another one: what differs, and whether it has the rays of the other.
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
  bool of_rays;        ///< the study of the file cannot become the other one by further solves
  std::string remedy = "use the scene with which the database was begun";
};
/// Compares physics, mesh, node sets, directions, increments and stored arrays themselves, not only their hashes.
std::vector<Difference> differences(const DatabaseHeader& on_disk, const DatabaseHeader& wanted);

/// @throws Error (input) with a difference that prevents the work, and its remedy
void refuse_other_work(const DatabaseHeader& on_disk, const DatabaseHeader& wanted, const std::filesystem::path& file);

}  // namespace phynness
