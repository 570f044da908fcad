// HDF5's driver for plain files, as a table of functions that our own drivers start from.
#pragma once

#include <hdf5.h>

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace phynness::hdf5 {

/// @param path, flags  of a file that exists and may be opened: the table is not public, but an open file
///                     points to it
/// @returns false if the file cannot be opened
bool find_plain_driver(const char* path, unsigned flags, H5FD_class_t& driver);

}  // namespace phynness::hdf5
