// Reading of HDF5 files. Every object is checked before its values are read: HDF5 itself reads values from other files,
// loads filters from folders, reads what was never written as zeros, and reads as many values as the file specifies,
// independently of the size of the caller's memory.
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <system_error>

#include "hdf5_file.hpp"

namespace phynness::hdf5 {
namespace {

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

/// Filters other than these come from plugins or, in HDF5 1.10, read beyond what they are given.
std::string filter_defect(hid_t properties) {
  for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
    std::size_t n_values = 0;
    const auto filter =
        H5Pget_filter2(properties, static_cast<unsigned>(i), nullptr, &n_values, nullptr, 0, nullptr, nullptr);
    if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32)
      return "it is compressed by a filter that databases do not use: number " + std::to_string(filter);
  }
  return "";
}

/// Chunks that were not written would be read as zeros.
std::string chunk_defect(hid_t dataset, hid_t properties, const Shape& shape) {
  Shape chunk(shape.size());
  if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) != static_cast<int>(shape.size()))
    return "its chunks have another rank";
  hsize_t wanted = 1, written = 0;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    if (chunk[k] == 0) return "its chunks are empty";
    wanted *= (shape[k] - 1) / chunk[k] + 1;
  }
#if H5_VERSION_GE(1, 10, 5)
  const Handle space(H5Dget_space(dataset), H5Sclose);
  if (H5Dget_num_chunks(dataset, space.id(), &written) < 0) return "its chunks cannot be counted";
  if (written != wanted) return std::to_string(written) + " of its " + std::to_string(wanted) + " chunks are stored";
#endif
  return "";
}

/// The defect of a dataset's storage, or empty. A valid dataset is stored in this file, has no filters except shuffle,
/// deflate and fletcher32, and is written completely.
std::string storage_defect(hid_t dataset, const Shape& shape, std::size_t bytes_per_value) {
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (properties.id() < 0) return "its storage cannot be read";
  const auto layout = H5Pget_layout(properties.id());
  // Reading a virtual dataset that is made of itself, HDF5 calls itself until the stack is used up.
  if (layout == H5D_VIRTUAL || H5Pget_external_count(properties.id()) != 0) return "its values are in another file";
  if (auto defect = filter_defect(properties.id()); !defect.empty()) return defect;
  const auto n_values = number_of_values(shape);
  if (n_values == 0) return "";
  if (layout == H5D_CHUNKED) return chunk_defect(dataset, properties.id(), shape);
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  if (stored == n_values * bytes_per_value) return "";
  return text(shape) + " values have " + std::to_string(bytes_per_value) + " bytes each, but " +
         std::to_string(stored) + " bytes are stored";
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
    throw input_error("the file is not an HDF5 file", path.string(), "give a database written by phynness precompute");
  File file({}, path, false);
  file._bytes = open_for_reading(path);
  std::error_code code;
  file._size = std::filesystem::file_size(path, code);
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
  // The size in memory would be that of a pointer to a text of variable length.
  const std::size_t stored = H5Tis_variable_str(found.type.id()) > 0 ? text_place_bytes : H5Tget_size(found.type.id());
  if (const auto defect = storage_defect(found.id.id(), found.shape, stored); !defect.empty()) refuse(name, defect);
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
    const Handle place_type = text_place_type();
    check(place_type.id(), what);
    unsigned char place[text_place_bytes] = {};
    check(read(place_type.id(), place), what);
    if (const auto defect = read_text_at(_bytes, _path, _size, place, result); !defect.empty()) refuse(what, defect);
  } else {
    const std::size_t size = H5Tget_size(type);
    if (size > _size || size > most_text_bytes)
      refuse(what + " is too long for this file", std::to_string(size) + " bytes");
    result.resize(size);
    check(read(type, result.data()), what);
    result = without_padding(std::move(result), H5Tget_strpad(type));
  }
  if (const auto at = result.find('\0'); at != std::string::npos)
    refuse(what + " contains zeros instead of characters", "from character " + std::to_string(at) + " on");
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
