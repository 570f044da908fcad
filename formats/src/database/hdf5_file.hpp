// HDF5 with handles that are closed automatically and with checked return codes. Messages of the library become part of
// our error messages.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace phynness::hdf5 {

/// HDF5's message about the last failure, from the innermost frame that has one.
std::string last_message();

class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : _id(id), _close(close) {}
  ~Handle() { close(); }
  Handle(Handle&& other) noexcept : _id(std::exchange(other._id, -1)), _close(other._close) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) close(), _id = std::exchange(other._id, -1), _close = other._close;
    return *this;
  }
  hid_t id() const { return _id; }
  /// Closes and returns the code, because data may be written only when an object is closed.
  herr_t close() { return _id < 0 ? 0 : _close(std::exchange(_id, -1)); }

 private:
  hid_t _id = -1;
  Close _close = nullptr;
};

using Shape = std::vector<hsize_t>;

/// Types of a C++ scalar in memory and in files (little-endian). `narrow` is a second stored type that can be read
/// without loss, or the same type.
struct Type {
  hid_t memory, stored, narrow;
  const char* name;
};
inline Type type_of(double) { return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, H5T_IEEE_F32LE, "float64 or float32"}; }
inline Type type_of(float) { return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE, H5T_IEEE_F32LE, "float32"}; }
inline Type type_of(std::int8_t) { return {H5T_NATIVE_INT8, H5T_STD_I8LE, H5T_STD_I8LE, "int8"}; }
inline Type type_of(std::uint8_t) { return {H5T_NATIVE_UINT8, H5T_STD_U8LE, H5T_STD_U8LE, "uint8"}; }
inline Type type_of(std::int32_t) { return {H5T_NATIVE_INT32, H5T_STD_I32LE, H5T_STD_I32LE, "int32"}; }
inline Type type_of(std::int64_t) { return {H5T_NATIVE_INT64, H5T_STD_I64LE, H5T_STD_I32LE, "int64 or int32"}; }
/// Stored as its code.
template <class Enum>
Type type_of(Enum value) requires(std::is_enum_v<Enum>) {
  return type_of(static_cast<std::underlying_type_t<Enum>>(value));
}

inline constexpr const char* damaged = "the file is damaged: restore it from a copy, or compute the database again";

/// An HDF5 file that is written or read. Failures throw Error: kind `input` for a file that cannot be read, `failure`
/// for a file that cannot be written. Both contain the file, the object and HDF5's message. A file that is read may
/// be damaged: every read checks that the object has the expected type and shape.
/// From the first file on HDF5 does not print its messages, which become part of our errors instead.
class File {
 public:
  /// @param bytes  as reserve()
  static File create(const std::filesystem::path& path, std::uint64_t bytes);
  static File create_in_memory();
  /// @throws Error (input) if the file is missing, not an HDF5 file, or truncated
  static File open(const std::filesystem::path& path);

  ~File();
  File(File&&) noexcept = default;
  File& operator=(File&&) noexcept = default;

  /// Closes the file. @throws Error if closing fails, which the destructor cannot report
  void close();
  const std::filesystem::path& path() const { return _path; }

  /// Reserves room on the disk for what is written next, because after a failed write HDF5 cannot close the file and
  /// crashes at exit. Where the file system reserves nothing, the free space is compared, and a quota is not seen.
  /// @param bytes  of the data; a margin for HDF5's own is added. @throws Error (failure)
  void reserve(std::uint64_t bytes);

  /// Throws an Error (input) for an object that is not as a database has it.
  [[noreturn]] void refuse(const std::string& what, const std::string& value) const;

  void create_group(const std::string& name);
  bool exists(const std::string& name) const;

  /// Creates a dataset with its 'unit' and 'description'. It is compressed by chunks, or contiguous if `chunk` is
  /// empty.
  void create_dataset(const std::string& name, hid_t stored_type, const Shape& shape, const Shape& chunk,
                      const std::string& unit, const std::string& description);
  /// Writes `count` entries of the leading dimension, starting at `first`, with all entries of the other dimensions.
  template <class T>
  void write_slab(const std::string& name, hsize_t first, hsize_t count, const T* values) {
    write_slab_raw(name, first, count, type_of(T{}).memory, values);
  }

  /// A compressed chunk, named by the indices of its first value.
  struct Chunk {
    std::string dataset;
    Shape first;
  };
  /// Appends a chunk to `bytes` as it is stored. @return the filters that were not applied, one bit for each
  std::uint32_t read_chunk(const Chunk& chunk, std::vector<unsigned char>& bytes) const;
  /// @param bytes  `size` of them, as read_chunk() gives them
  void write_chunk(const Chunk& chunk, const unsigned char* bytes, std::size_t size, std::uint32_t filter_mask);

  const Shape& shape(const std::string& name) const { return dataset(name).shape; }
  /// @return the number of values
  /// @throws Error (input) unless the dataset has exactly this shape
  std::size_t check_shape(const std::string& name, const Shape& expected) const;
  /// @throws Error (input) unless the dataset has exactly this shape and the type of T
  template <class T>
  std::vector<T> read(const std::string& name, const Shape& expected) const {
    std::vector<T> values(check_shape(name, expected));
    read_slab(name, 0, expected[0], values.data());
    return values;
  }
  /// Reads `count` entries of the leading dimension, starting at `first`, with all entries of the other dimensions.
  /// @pre the caller has checked the shape of the dataset
  template <class T>
  void read_slab(const std::string& name, hsize_t first, hsize_t count, T* values) const {
    read_slab_raw(name, first, count, type_of(T{}), values);
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
  /// A dataset or an attribute.
  struct Object {
    Handle id, type;
    Shape shape;
  };

  File(Handle file, std::filesystem::path path, bool writing)
      : _path(std::move(path)), _writing(writing), _file(std::move(file)) {}
  [[noreturn]] void fail(const std::string& what) const;
  template <class Code>
  Code check(Code code, const std::string& what) const {
    if (code < 0) fail(what);
    return code;
  }
  void write_slab_raw(const std::string& name, hsize_t first, hsize_t count, hid_t type, const void* values);

  Object checked(Handle id, const Handle& space, Handle type, const std::string& what) const;
  const Object& dataset(const std::string& name) const;
  Object attribute(const std::string& object, const std::string& name) const;
  void read_slab_raw(const std::string& name, hsize_t first, hsize_t count, const Type& type, void* values) const;
  void write_attribute_raw(const std::string& object, const std::string& name, hid_t stored, hid_t memory,
                           const Handle& space, const void* values);
  template <class Read>
  std::string text_of(const std::string& what, const Object& object, const Read& read) const;

  std::filesystem::path _path;
  bool _writing = false;
  Handle _file;
  // Datasets read so far. They are checked once, and remain open because an open dataset keeps its last unpacked chunk.
  mutable std::map<std::string, Object> _datasets;
};

}  // namespace phynness::hdf5
