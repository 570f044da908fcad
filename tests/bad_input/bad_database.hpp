// A packed database and ways to break it by HDF5 itself.
#pragma once

#include <hdf5.h>

#include "../formats/database_under_test.hpp"

namespace phynness::test {

class BadDatabase : public DatabaseTest {
 protected:
  void write_packed() {
    const auto header = small_header(true);
    write_database(header);
  }
  void write_packed_again() {
    if (_packed.empty()) {
      fs::remove(file);
      write_packed();
      _packed = bytes_of(file);
    }
    write_bytes(file, _packed);
  }
  /// Opens the file with HDF5 itself, to break what our own code cannot.
  template <class Work>
  void tamper(Work&& work) {
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    ASSERT_GE(id, 0);
    work(id);
    H5Fclose(id);
  }
  void set_attribute(const char* name, std::int32_t value) {
    tamper([&](hid_t id) {
      const hid_t attribute = H5Aopen(id, name, H5P_DEFAULT);
      ASSERT_GE(H5Awrite(attribute, H5T_NATIVE_INT32, &value), 0);
      H5Aclose(attribute);
    });
  }
  std::string open_error() {
    return refusal([&] { Database::open(file); });
  }

 private:
  std::vector<char> _packed;
};

}  // namespace phynness::test
