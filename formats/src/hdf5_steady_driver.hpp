// Writing HDF5 files to a disk that may be full. After a failed write HDF5 (1.10 to 1.14) cannot close the
// file any more and crashes when it shuts down, at exit or in MPI_Finalize. So its own driver for plain files
// is wrapped: the first failure is remembered, HDF5 is told that all went well, and the caller asks here and
// throws the file away.
#pragma once

#include <hdf5.h>

namespace phynness::hdf5 {

/// Makes `access` (a file access property list) use the wrapped driver. `path` is a file that may be written.
/// Negative on failure.
herr_t use_steady_driver(hid_t access, const char* path);

/// errno of the first write that failed since forget_write_error(); 0 if none did. One file at a time is
/// written.
int write_error();
void forget_write_error();

}  // namespace phynness::hdf5
