// For builds without Node, npm or clang for WebAssembly.
#include "embedded.hpp"

namespace phynness {

const EmbeddedFile embedded_files[] = {{nullptr, nullptr}};

}  // namespace phynness
