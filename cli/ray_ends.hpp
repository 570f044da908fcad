// Where the rays of a database or of a sample end, in words and as JSON.
#pragma once

#include <phynness/formats/database.hpp>

#include "commands.hpp"

namespace phynness::cli {

/// Prints which share of the rays and of the probe volume ends early, why, and at which nodes. Prints nothing if every
/// ray reaches its full depth. @return the figures
json tell_ends(const DatabaseHeader& header, const EndSummary& ends);

}  // namespace phynness::cli
