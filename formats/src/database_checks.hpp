// What the numbers of a database's header may be, checked where they are read and where they are written:
// code further on takes them as indices, counts and divisors.
#pragma once

#include <phynness/formats/database.hpp>
#include <string>

namespace phynness {

/// @param where  starts the message: "the database FILE"
/// @throws Error (input) naming the first dataset, entry and value that cannot be
void check_header(const DatabaseHeader& header, const std::string& where);

/// Largest distance [m] by which a point of the body may be displaced and still be believed: a hundred times
/// the diagonal of the box round the body.
double largest_displacement(const Mesh& mesh);

}  // namespace phynness
