// Checks of the header of a database: of its numbers, when it is read and when it is written, because other code uses
// them as indices, counts and divisors; and whether the present run can continue it.
#pragma once

#include <filesystem>
#include <phynness/formats/database.hpp>
#include <string>

namespace phynness {

/// @param where  start of the message: "the database FILE"
/// @throws Error (input) with the first invalid dataset, entry and value
void check_header(const DatabaseHeader& header, const std::string& where);

/// Largest plausible displacement [m] of a point of the body: a hundred diagonals of its bounding box.
double largest_displacement(const Mesh& mesh);

}  // namespace phynness
