#include "hdf5_heapless_driver.hpp"

#include <cstring>

#include "hdf5_plain_driver.hpp"

namespace phynness::hdf5 {
namespace {

H5FD_class_t plain_to_read{};

herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t transfer, haddr_t at, std::size_t size, void* bytes) {
  if (plain_to_read.read(file, type, transfer, at, size, bytes) < 0) return -1;
  if (size < sizeof heap_signature || std::memcmp(bytes, heap_signature, sizeof heap_signature) != 0) return 0;
  H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_HEAP, H5E_READERROR,
           "an object needs a global heap, but databases use a global heap for texts only");
  return -1;
}

hid_t heapless_driver(const char* path) {
  static hid_t driver = -1;
  static H5FD_class_t heapless{};
  if (driver >= 0 || !find_plain_driver(path, H5F_ACC_RDONLY, plain_to_read)) return driver;
  heapless = plain_to_read;
  heapless.name = "phynness_heapless";
#if H5_VERSION_GE(1, 13, 0)
  heapless.value = static_cast<H5FD_class_value_t>(601);  // from the range that HDF5 reserves for other drivers
#endif
  heapless.terminate = nullptr;
  heapless.read = read;
  return driver = H5FDregister(&heapless);
}

}  // namespace

herr_t use_heapless_driver(hid_t access, const char* path) {
  const hid_t driver = heapless_driver(path);
  return driver < 0 ? -1 : H5Pset_driver(access, driver, nullptr);
}

}  // namespace phynness::hdf5
