// For builds without Node, npm or clang for WebAssembly.
#include "embedded.hpp"

const char* const phynness::embedded_page_chunks[] = {nullptr};
