// A driver for writing HDF5 files to a disk that may become full. After a failed write HDF5 (1.10 to 1.14) cannot close
// the file and crashes at exit or in MPI_Finalize. Therefore this driver wraps the one for plain files: it stores the
// first error and reports success to HDF5; the caller checks write_error() and deletes the file. It also tells where
// HDF5 would write raw data that other processes write.
#include <cerrno>

#include "hdf5_file.hpp"
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

namespace phynness::hdf5 {
namespace {

int first_error = 0;
haddr_t* place_of_raw_data = nullptr;
H5FD_class_t plain_to_write{};  // HDF5's driver for plain files

void remember() {
  if (first_error == 0) first_error = errno != 0 ? errno : EIO;
  H5Eclear2(H5E_DEFAULT);
}

herr_t write(H5FD_t* file, H5FD_mem_t type, hid_t transfer, haddr_t at, std::size_t size, const void* bytes) {
  if (place_of_raw_data && type == H5FD_MEM_DRAW) {
    *place_of_raw_data = at;
  } else if (first_error == 0) {
    errno = 0;
    if (plain_to_write.write(file, type, transfer, at, size, bytes) < 0) remember();
  }
  return 0;
}

herr_t truncate(H5FD_t* file, hid_t transfer, hbool_t closing) {
  if (first_error == 0) {
    errno = 0;
    if (plain_to_write.truncate(file, transfer, closing) < 0) remember();
  }
  return 0;
}

/// The table of functions is not public, but an open file points to it.
bool find_plain_driver(const char* path) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5FD_t* file = H5Pset_fapl_sec2(access) >= 0 ? H5FDopen(path, H5F_ACC_RDWR, access, HADDR_UNDEF) : nullptr;
  if (file) {
    plain_to_write = *file->cls;
    H5FDclose(file);
  }
  H5Pclose(access);
  return file != nullptr;
}

hid_t steady_driver(const char* path) {
  static hid_t driver = -1;
  static H5FD_class_t steady{};
  if (driver >= 0 || !find_plain_driver(path)) return driver;
  steady = plain_to_write;
  steady.name = "phynness_steady";
#if H5_VERSION_GE(1, 13, 0)
  steady.value = static_cast<H5FD_class_value_t>(600);  // from the range that HDF5 reserves for other drivers
#endif
  steady.terminate = nullptr;
  steady.write = write;
  steady.truncate = truncate;
  return driver = H5FDregister(&steady);
}

}  // namespace

herr_t use_steady_driver(hid_t access, const char* path) {
  const hid_t driver = steady_driver(path);
  return driver < 0 ? -1 : H5Pset_driver(access, driver, nullptr);
}

int write_error() { return first_error; }
void forget_write_error() { first_error = 0; }
void leave_raw_data_out(haddr_t* place) { place_of_raw_data = place; }

}  // namespace phynness::hdf5
