// The namespace of the runtime's internals. Each precision has its own, so that a program can link both libraries.
// Images, which do not depend on this precision, are in the namespace of double.
#pragma once

#ifdef PHYNNESS_FLOAT
#define PHN_RUNTIME phynness::runtime_float
namespace phynness {
namespace runtime_float {}
namespace runtime = runtime_float;
}  // namespace phynness
#else
#define PHN_RUNTIME phynness::runtime
#endif
