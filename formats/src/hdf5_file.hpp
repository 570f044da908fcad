// HDF5 with handles that close themselves and every code checked; messages of the library end up in ours.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "durable_file.hpp"
#include "hdf5_steady_driver.hpp"

namespace phynness::hdf5 {

/// While one lives, HDF5 prints nothing: what it has to say goes into our errors. The setting is the whole
/// process's, so it is put back after every call.
class Quiet {
 public:
  Quiet();
  ~Quiet();
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

 private:
  H5E_auto2_t _function = nullptr;
  void* _data = nullptr;
};

/// HDF5's own account of the last failure: the innermost frame that says something.
std::string last_message();

class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : _id(id), _close(close) {}
  ~Handle() { reset(); }
  Handle(Handle&& other) noexcept : _id(std::exchange(other._id, -1)), _close(other._close) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) reset(), _id = std::exchange(other._id, -1), _close = other._close;
    return *this;
  }
  hid_t id() const { return _id; }
  void reset() {
    if (_id >= 0) _close(_id);
    _id = -1;
  }
  /// Closes where the code matters: data may be written only now.
  herr_t close() { return _id < 0 ? 0 : _close(std::exchange(_id, -1)); }

 private:
  hid_t _id = -1;
  Close _close = nullptr;
};

using Shape = std::vector<hsize_t>;

/// In-memory and stored type of a C++ scalar (stored little-endian). `narrow` is one more stored type that is
/// read without loss, or the same.
template <class T>
struct Type;
template <>
struct Type<double> {
  static hid_t memory() { return H5T_NATIVE_DOUBLE; }
  static hid_t stored() { return H5T_IEEE_F64LE; }
  static hid_t narrow() { return H5T_IEEE_F32LE; }
  static constexpr const char* name = "float64 or float32";
};
template <>
struct Type<float> {
  static hid_t memory() { return H5T_NATIVE_FLOAT; }
  static hid_t stored() { return H5T_IEEE_F32LE; }
  static hid_t narrow() { return stored(); }
  static constexpr const char* name = "float32";
};
template <>
struct Type<std::int8_t> {
  static hid_t memory() { return H5T_NATIVE_INT8; }
  static hid_t stored() { return H5T_STD_I8LE; }
  static hid_t narrow() { return stored(); }
  static constexpr const char* name = "int8";
};
template <>
struct Type<std::uint8_t> {
  static hid_t memory() { return H5T_NATIVE_UINT8; }
  static hid_t stored() { return H5T_STD_U8LE; }
  static hid_t narrow() { return stored(); }
  static constexpr const char* name = "uint8";
};
template <>
struct Type<std::int32_t> {
  static hid_t memory() { return H5T_NATIVE_INT32; }
  static hid_t stored() { return H5T_STD_I32LE; }
  static hid_t narrow() { return stored(); }
  static constexpr const char* name = "int32";
};

/// What a reader takes for a dataset's values.
struct WantedType {
  hid_t memory, stored, narrow;
  const char* name;
};
template <class T>
WantedType wanted() {
  return {Type<T>::memory(), Type<T>::stored(), Type<T>::narrow(), Type<T>::name};
}

/// One HDF5 file, to be written, or to be read. Failures throw Error: kind `input` for a file that cannot be
/// read, `failure` for one that cannot be written; both name the file, the object and HDF5's own message.
/// A file that is read may come from anywhere: every read checks that the object is one of this file (no link
/// to another), of the type and shape that the caller has room for, and stored in bytes that the file has.
class File {
 public:
  static File create(const std::filesystem::path& path);
  /// @throws Error if the file is missing, no HDF5 file, or truncated: each its own message
  static File open(const std::filesystem::path& path);

  ~File();
  File(File&&) noexcept = default;
  File& operator=(File&&) noexcept = default;

  /// Closes and reports what closing had to say; the destructor cannot.
  void close();
  const std::filesystem::path& path() const { return _path; }

  void create_group(const std::string& name);
  /// @throws Error if there is a link to another place instead
  bool exists(const std::string& name) const;

  /// A dataset with its 'unit' and 'description'. An empty `chunk` stores it contiguously, else compressed by
  /// chunk.
  void create_dataset(const std::string& name, hid_t stored_type, const Shape& shape, const Shape& chunk,
                      const std::string& unit, const std::string& description);
  template <class T>
  void write(const std::string& name, const T* values) {
    write_raw(name, Type<T>::memory(), values);
  }
  /// `count` entries of the leading dimension from `first` on, all of the other dimensions.
  template <class T>
  void write_slab(const std::string& name, hsize_t first, hsize_t count, const T* values) {
    write_slab_raw(name, first, count, Type<T>::memory(), values);
  }

  /// The shape of a dataset, whose values are then known to be stored in this file.
  Shape shape(const std::string& name) const;
  /// @throws Error unless the dataset has exactly this shape
  void require_shape(const std::string& name, const Shape& expected) const { check_shape(name, expected); }
  /// @throws Error unless the dataset has exactly this shape, and the type
  template <class T>
  std::vector<T> read(const std::string& name, const Shape& expected) const {
    std::vector<T> values(check_shape(name, expected));
    read_raw(name, wanted<T>(), values.data());
    return values;
  }
  /// `count` entries of the leading dimension from `first` on, all of the other dimensions.
  /// @pre the caller has checked the shape of the dataset
  template <class T>
  void read_slab(const std::string& name, hsize_t first, hsize_t count, T* values) const {
    read_slab_raw(name, first, count, wanted<T>(), values);
  }

  /// Attributes of an object ("/" is the root).
  void write_attribute(const std::string& object, const std::string& name, const std::string& text);
  void write_attribute(const std::string& object, const std::string& name, const std::vector<std::int8_t>& values);
  void write_attribute(const std::string& object, const std::string& name, std::int32_t value);
  std::string read_text_attribute(const std::string& object, const std::string& name) const;
  std::int32_t read_int_attribute(const std::string& object, const std::string& name) const;
  bool has_attribute(const std::string& object, const std::string& name) const;

  void write_text(const std::string& name, const std::string& text, const std::string& description);
  std::string read_text(const std::string& name) const;

 private:
  struct Dataset {
    Handle id, type;
    Shape shape;
  };

  File(Handle file, std::filesystem::path path, bool writing)
      : _path(std::move(path)), _writing(writing), _file(std::move(file)) {}
  [[noreturn]] void fail(const std::string& what) const;
  /// What is read is not what a database has there.
  [[noreturn]] void refuse(const std::string& what, const std::string& value) const;
  template <class Code>
  Code check(Code code, const std::string& what) const {
    if (code < 0 || (_writing && write_error() != 0)) fail(what);
    return code;
  }
  void write_raw(const std::string& name, hid_t type, const void* values);
  void write_slab_raw(const std::string& name, hsize_t first, hsize_t count, hid_t type, const void* values);

  const Dataset& dataset(const std::string& name) const;
  const Dataset& dataset(const std::string& name, const WantedType& type) const;
  std::size_t check_shape(const std::string& name, const Shape& expected) const;
  void read_raw(const std::string& name, const WantedType& type, void* values) const;
  void read_slab_raw(const std::string& name, hsize_t first, hsize_t count, const WantedType& type, void* values) const;
  Handle open_attribute(const std::string& object, const std::string& name) const;
  template <class Read>
  std::string text_of(const std::string& what, hid_t type, const Shape& shape, const Read& read) const;

  std::filesystem::path _path;
  bool _writing = false;
  Descriptor _bytes;  // of a file that is read
  std::uint64_t _size = 0;
  Handle _file;
  // Those read so far, checked once. Open, they keep the last chunk unpacked.
  mutable std::map<std::string, Dataset> _datasets;
};

}  // namespace phynness::hdf5
