#include "hdf5_plain_driver.hpp"

namespace phynness::hdf5 {

bool find_plain_driver(const char* path, unsigned flags, H5FD_class_t& driver) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5FD_t* file = access >= 0 && H5Pset_fapl_sec2(access) >= 0 ? H5FDopen(path, flags, access, HADDR_UNDEF) : nullptr;
  if (file) {
    driver = *file->cls;
    H5FDclose(file);
  }
  if (access >= 0) H5Pclose(access);
  return file != nullptr;
}

}  // namespace phynness::hdf5
