// The namespace of the runtime's internals: one for each precision, so that a program may hold both libraries. What
// does not depend on the precision, images, lies in that of double.
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
