// The version of this software, as recorded in databases and models.
#pragma once

#include <string>

namespace phynness {

/// "phynness 0.1.0"
std::string software_version();

}  // namespace phynness
