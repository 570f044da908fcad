// A driver for reading that gives HDF5 no global heap: the place where texts of variable length and the lists
// of virtual datasets are kept. A heap has no checksum, and HDF5 1.10 trusts what it finds there: a zeroed
// block makes it loop for ever, and wrong sizes make it copy beyond its buffers. Our own code reads those
// texts (hdf5_text.hpp).
#pragma once

#include <hdf5.h>

namespace phynness::hdf5 {

/// Sets the driver in a file access property list.
/// @param path  of a file that can be read
/// @returns negative if HDF5 refuses
herr_t use_heapless_driver(hid_t access, const char* path);

/// Starts every block of a global heap.
inline constexpr char heap_signature[] = {'G', 'C', 'O', 'L'};

}  // namespace phynness::hdf5
