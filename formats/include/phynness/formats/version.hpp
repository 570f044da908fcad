// The version that databases and models record.
#pragma once

#include <string>

namespace phynness {

/// "phynness 0.1.0"
std::string software_version();

}  // namespace phynness
