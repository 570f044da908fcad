#include <phynness/formats/version.hpp>

namespace phynness {

std::string software_version() { return "phynness " PHYNNESS_VERSION; }

}  // namespace phynness
