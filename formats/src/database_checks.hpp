// Checks of the numbers in the header of a database, when it is read and when it is written. Other code uses these
// numbers as indices, counts and divisors.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>

namespace phynness {

/// @param where  start of the message: "the database FILE"
/// @throws Error (input) with the first invalid dataset, entry and value
void check_header(const DatabaseHeader& header, const std::string& where);

/// Largest plausible displacement [m] of a point of the body: a hundred diagonals of its bounding box.
double largest_displacement(const Mesh& mesh);

}  // namespace phynness
