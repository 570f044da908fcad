// Reading of HDF5 files. Every object is checked before its values are read (hdf5_checks.hpp).
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/formats/input_file.hpp>
#include <system_error>

#include "hdf5_checks.hpp"
#include "hdf5_file.hpp"
#include "hdf5_text.hpp"

namespace phynness::hdf5 {
namespace {

/// A text of fixed length ends at the first NUL or before trailing blanks.
std::string without_padding(std::string text, H5T_str_t padding) {
  text.resize(std::min(text.size(), text.find('\0')));
  if (padding == H5T_STR_SPACEPAD) text.resize(text.find_last_not_of(' ') + 1);
  return text;
}

}  // namespace

File File::open(const std::filesystem::path& path) {
  const Quiet quiet;
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

bool File::exists(const std::string& name) const {
  const Quiet quiet;
  return H5Lexists(_file.id(), name.c_str(), H5P_DEFAULT) > 0;
}

const File::Dataset& File::dataset(const std::string& name) const {
  if (const auto known = _datasets.find(name); known != _datasets.end()) return known->second;
  if (!exists(name)) refuse(name + " is missing", "");
  Dataset found;
  found.id = Handle(H5Dopen2(_file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  check(found.id.id(), name);
  const Handle space(H5Dget_space(found.id.id()), H5Sclose);
  found.type = Handle(H5Dget_type(found.id.id()), H5Tclose);
  check(space.id(), name);
  check(found.type.id(), name);
  if (!read_shape(space.id(), found.shape)) refuse(name, "it has no values");
  // The size in memory would be that of a pointer to a text of variable length.
  const std::size_t stored = H5Tis_variable_str(found.type.id()) > 0 ? text_place_bytes : H5Tget_size(found.type.id());
  if (const auto defect = storage_defect(found.id.id(), found.shape, stored); !defect.empty()) refuse(name, defect);
  return _datasets.emplace(name, std::move(found)).first->second;
}

const File::Dataset& File::dataset(const std::string& name, const Type& type) const {
  const Dataset& found = dataset(name);
  if (H5Tequal(found.type.id(), type.stored) <= 0 && H5Tequal(found.type.id(), type.narrow) <= 0)
    refuse(name + " has the wrong type", name_of_type(found.type.id()) + " instead of " + type.name);
  return found;
}

Shape File::shape(const std::string& name) const {
  const Quiet quiet;
  return dataset(name).shape;
}

std::size_t File::check_shape(const std::string& name, const Shape& expected) const {
  const Shape found = shape(name);
  if (found != expected) refuse(name + " has the wrong shape", text(found) + " instead of " + text(expected));
  return number_of_values(found);
}

void File::read_raw(const std::string& name, const Type& type, void* values) const {
  const Quiet quiet;
  if (values == nullptr) {  // there are no values, but the type is checked
    dataset(name, type);
    return;
  }
  check(H5Dread(dataset(name, type).id.id(), type.memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), name);
}

void File::read_slab_raw(const std::string& name, hsize_t first, hsize_t count, const Type& type, void* values) const {
  const Quiet quiet;
  const Dataset& from = dataset(name, type);
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
  const Quiet quiet;
  return H5Aexists_by_name(_file.id(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

Handle File::open_attribute(const std::string& object, const std::string& name) const {
  if (!has_attribute(object, name)) refuse("attribute " + name + " of " + object + " is missing", "");
  Handle attribute(H5Aopen_by_name(_file.id(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(attribute.id(), "attribute " + name + " of " + object);
  return attribute;
}

std::int32_t File::read_int_attribute(const std::string& object, const std::string& name) const {
  const Quiet quiet;
  const Handle attribute = open_attribute(object, name);
  const std::string what = "attribute " + name + " of " + object;
  const Handle space(H5Aget_space(attribute.id()), H5Sclose), type(H5Aget_type(attribute.id()), H5Tclose);
  check(space.id(), what);
  check(type.id(), what);
  Shape shape;
  if (!read_shape(space.id(), shape) || !shape.empty())
    refuse(what + " is not a single number", shape.empty() ? "it has no value" : text(shape));
  if (H5Tget_class(type.id()) != H5T_INTEGER) refuse(what + " is not an integer", name_of_type(type.id()));
  std::int64_t value = 0;
  check(H5Aread(attribute.id(), H5T_NATIVE_INT64, &value), what);
  if (value < std::numeric_limits<std::int32_t>::min() || value > std::numeric_limits<std::int32_t>::max())
    refuse(what + " is too large", std::to_string(value));
  return static_cast<std::int32_t>(value);
}

/// @param read  reads a value of a memory type into a buffer of sufficient size
template <class Read>
std::string File::text_of(const std::string& what, hid_t type, const Shape& shape, const Read& read) const {
  if (!shape.empty()) refuse(what + " is not a single text", text(shape));
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
  const Quiet quiet;
  const Handle attribute = open_attribute(object, name);
  const std::string what = "attribute " + name + " of " + object;
  const Handle space(H5Aget_space(attribute.id()), H5Sclose), type(H5Aget_type(attribute.id()), H5Tclose);
  check(space.id(), what);
  check(type.id(), what);
  Shape shape;
  if (!read_shape(space.id(), shape)) refuse(what + " has no value", "");
  return text_of(what, type.id(), shape, [&](hid_t memory, void* to) { return H5Aread(attribute.id(), memory, to); });
}

std::string File::read_text(const std::string& name) const {
  const Quiet quiet;
  const Dataset& from = dataset(name);
  return text_of(name, from.type.id(), from.shape, [&](hid_t memory, void* to) {
    return H5Dread(from.id.id(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, to);
  });
}

}  // namespace phynness::hdf5
