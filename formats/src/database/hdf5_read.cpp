// Reading of HDF5 files. The type and the shape of an object are checked before its values are read: HDF5 itself reads
// as many values as the file specifies, independently of the size of the caller's memory.
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>

#include "hdf5_file.hpp"

namespace phynness::hdf5 {
namespace {

/// More than any scene that is read.
constexpr std::size_t most_text_bytes = 32 << 20;

/// The product of the extents, limited to the largest number of the type.
std::uint64_t number_of_values(const Shape& shape) {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  std::uint64_t number = 1;
  for (const auto n : shape) number = n != 0 && number > most / n ? most : number * n;
  return number;
}

/// "[6, 3]"
std::string text(const Shape& shape) {
  if (shape.empty()) return "one value";
  std::string text = "[";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
  return text + "]";
}

/// Name of a type for messages: "int32", "float64", "text".
std::string name_of_type(hid_t type) {
  const auto bits = std::to_string(8 * H5Tget_size(type));
  const std::string order = H5Tget_order(type) == H5T_ORDER_BE ? ", big-endian" : "";
  switch (H5Tget_class(type)) {
    case H5T_INTEGER:
      return (H5Tget_sign(type) == H5T_SGN_NONE ? "uint" : "int") + bits + order;
    case H5T_FLOAT:
      return "float" + bits + order;
    case H5T_STRING:
      return "text";
    default:
      return "another kind of type";
  }
}

/// The shape of a dataset or attribute with one value or an array of them.
/// @return false if it has no shape (a null dataspace)
bool read_shape(hid_t space, Shape& shape) {
  shape.clear();
  const auto kind = H5Sget_simple_extent_type(space);
  if (kind == H5S_SCALAR) return true;
  const int rank = H5Sget_simple_extent_ndims(space);
  if (kind != H5S_SIMPLE || rank < 0) return false;
  shape.resize(static_cast<std::size_t>(rank));
  return H5Sget_simple_extent_dims(space, shape.data(), nullptr) == rank;
}

/// A text of fixed length ends at the first NUL or before trailing blanks.
std::string without_padding(std::string text, H5T_str_t padding) {
  text.resize(std::min(text.size(), text.find('\0')));
  if (padding == H5T_STR_SPACEPAD) text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

File File::open(const std::filesystem::path& path) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  require_input_file(
      path, {"the database", "correct the path, or compute it with: phynness precompute SCENE -o " + path.string(),
             std::numeric_limits<std::uint64_t>::max()});
  if (H5Fis_hdf5(path.c_str()) <= 0)
    throw input_error("the file is not an HDF5 file", path.string(),
                      "give a database written by phynness precompute, and move this file if it has the place of one");
  File file({}, path, false);
  file._file = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (file._file.id() < 0) {
    const auto said = last_message();
    if (said.find("truncated") != std::string::npos)
      throw input_error("the database is truncated: " + path.string(), said,
                        "copy the complete file again, or compute the database again");
    throw input_error("cannot open the database " + path.string(), said, damaged);
  }
  return file;
}

void File::refuse(const std::string& what, const std::string& value) const {
  throw input_error("cannot read the database " + _path.string() + ": " + what, value, damaged);
}

bool File::exists(const std::string& name) const { return H5Lexists(_file.id(), name.c_str(), H5P_DEFAULT) > 0; }

File::Object File::checked(Handle id, const Handle& space, Handle type, const std::string& what) const {
  Object object{std::move(id), std::move(type), {}};
  for (const hid_t handle : {object.id.id(), space.id(), object.type.id()}) check(handle, what);
  if (!read_shape(space.id(), object.shape)) refuse(what + " has no value", "");
  return object;
}

const File::Object& File::dataset(const std::string& name) const {
  if (const auto known = _datasets.find(name); known != _datasets.end()) return known->second;
  if (!exists(name)) refuse(name + " is missing", "");
  Handle id(H5Dopen2(_file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  check(id.id(), name);
  const Handle space(H5Dget_space(id.id()), H5Sclose);
  Handle type(H5Dget_type(id.id()), H5Tclose);
  Object found = checked(std::move(id), space, std::move(type), name);
  return _datasets.emplace(name, std::move(found)).first->second;
}

std::size_t File::check_shape(const std::string& name, const Shape& expected) const {
  const Shape& found = shape(name);
  if (found != expected) refuse(name + " has the wrong shape", text(found) + " instead of " + text(expected));
  return number_of_values(found);
}

void File::read_slab_raw(const std::string& name, hsize_t first, hsize_t count, const Type& type, void* values) const {
  const Object& from = dataset(name);
  if (H5Tequal(from.type.id(), type.stored) <= 0 && H5Tequal(from.type.id(), type.narrow) <= 0)
    refuse(name + " has the wrong type", name_of_type(from.type.id()) + " instead of " + type.name);
  if (values == nullptr) return;  // there are none
  Shape extent = from.shape, start(extent.size(), 0);
  if (extent.empty() || first > extent[0] || count > extent[0] - first)
    refuse(name + " has too few entries", text(extent) + ", but entry " + std::to_string(first) + " is needed");
  extent[0] = count;
  start[0] = first;
  const Handle space(H5Dget_space(from.id.id()), H5Sclose);
  check(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr), name);
  const Handle memory(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
  check(H5Dread(from.id.id(), type.memory, memory.id(), space.id(), H5P_DEFAULT, values),
        name + ", entry " + std::to_string(first));
}

bool File::has_attribute(const std::string& object, const std::string& name) const {
  return H5Aexists_by_name(_file.id(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

File::Object File::attribute(const std::string& object, const std::string& name) const {
  const std::string what = "attribute " + name + " of " + object;
  if (!has_attribute(object, name)) refuse(what + " is missing", "");
  Handle id(H5Aopen_by_name(_file.id(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(id.id(), what);
  const Handle space(H5Aget_space(id.id()), H5Sclose);
  Handle type(H5Aget_type(id.id()), H5Tclose);
  return checked(std::move(id), space, std::move(type), what);
}

std::int32_t File::read_int_attribute(const std::string& object, const std::string& name) const {
  const Object found = attribute(object, name);
  const std::string what = "attribute " + name + " of " + object;
  if (!found.shape.empty()) refuse(what + " is not a single number", text(found.shape));
  if (H5Tget_class(found.type.id()) != H5T_INTEGER) refuse(what + " is not an integer", name_of_type(found.type.id()));
  std::int64_t value = 0;
  check(H5Aread(found.id.id(), H5T_NATIVE_INT64, &value), what);
  if (value < std::numeric_limits<std::int32_t>::min() || value > std::numeric_limits<std::int32_t>::max())
    refuse(what + " is too large", std::to_string(value));
  return static_cast<std::int32_t>(value);
}

/// @param read  reads a value of a memory type into a buffer of sufficient size
template <class Read>
std::string File::text_of(const std::string& what, const Object& object, const Read& read) const {
  const hid_t type = object.type.id();
  if (!object.shape.empty()) refuse(what + " is not a single text", text(object.shape));
  if (H5Tget_class(type) != H5T_STRING) refuse(what + " is not a text", name_of_type(type));
  std::string result;
  if (H5Tis_variable_str(type) > 0) {
    char* found = nullptr;
    check(read(type, &found), what);
    if (found) result = found;
    H5free_memory(found);
  } else {
    const std::size_t size = H5Tget_size(type);
    if (size > most_text_bytes) refuse(what + " is too long", std::to_string(size) + " bytes");
    result.resize(size);
    check(read(type, result.data()), what);
    result = without_padding(std::move(result), H5Tget_strpad(type));
  }
  return result;
}

std::string File::read_text_attribute(const std::string& object, const std::string& name) const {
  const Object from = attribute(object, name);
  return text_of("attribute " + name + " of " + object, from,
                 [&](hid_t memory, void* to) { return H5Aread(from.id.id(), memory, to); });
}

std::string File::read_text(const std::string& name) const {
  const Object& from = dataset(name);
  return text_of(name, from, [&](hid_t memory, void* to) {
    return H5Dread(from.id.id(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, to);
  });
}

}  // namespace phynness::hdf5
