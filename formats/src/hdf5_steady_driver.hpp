// A driver for writing HDF5 files to a disk that may become full. After a failed write HDF5 (1.10 to 1.14) cannot close
// the file and crashes at exit or in MPI_Finalize. Therefore this driver wraps the one for plain files: it stores the
// first error and reports success to HDF5; the caller checks write_error() and deletes the file.
#pragma once

#include <hdf5.h>

namespace phynness::hdf5 {

/// Sets the wrapped driver in a file access property list.
/// @param path  of a writable file
/// @return negative on failure
herr_t use_steady_driver(hid_t access, const char* path);

/// errno of the first failed write since forget_write_error(); 0: none. Only one file may be written at a time.
int write_error();
void forget_write_error();

}  // namespace phynness::hdf5
