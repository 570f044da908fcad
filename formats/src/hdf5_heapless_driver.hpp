// A driver for reading that hides global heaps from HDF5. A global heap contains texts of variable length and the lists
// of virtual datasets. It has no checksum, and HDF5 1.10 does not validate it: a zeroed block causes an infinite loop,
// and wrong sizes cause copies beyond buffers. Our own code reads these texts (hdf5_text.hpp).
#pragma once

#include <hdf5.h>

namespace phynness::hdf5 {

/// Sets the driver in a file access property list.
/// @param path  of a readable file
/// @return negative on failure
herr_t use_heapless_driver(hid_t access, const char* path);

/// First bytes of every block of a global heap.
inline constexpr char heap_signature[] = {'G', 'C', 'O', 'L'};

}  // namespace phynness::hdf5
