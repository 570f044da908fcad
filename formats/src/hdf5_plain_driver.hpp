// The function table of HDF5's driver for plain files, on which our own drivers are based.
#pragma once

#include <hdf5.h>

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace phynness::hdf5 {

/// @param path, flags  of an existing file that can be opened: the table is not public, but an open file points to it
/// @return false if the file cannot be opened
bool find_plain_driver(const char* path, unsigned flags, H5FD_class_t& driver);

}  // namespace phynness::hdf5
