#include "hdf5_file.hpp"

#include <phynness/formats/error.hpp>

#include "text/durable_file.hpp"

namespace phynness::hdf5 {
namespace {

const char* const not_written =
    "check free space (df) and permissions, then run again with --resume: logged rays are kept";

/// Twice what HDF5 needs for the names, types and indices of a database beside its data.
constexpr std::uint64_t margin_bytes = 32 << 10;

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.id(), H5T_VARIABLE);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

/// Without time stamps the same responses give the same file.
Handle without_times(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  return properties;
}

Handle scalar_space() { return {H5Screate(H5S_SCALAR), H5Sclose}; }

}  // namespace

std::string last_message() {
  std::string message;
  const auto visit = [](unsigned, const H5E_error2_t* frame, void* data) -> herr_t {
    auto& text = *static_cast<std::string*>(data);
    if (text.empty() && frame->desc) text = frame->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, visit, &message);
  return "HDF5: " + (message.empty() ? std::string("no message") : message);
}

void File::fail(const std::string& what) const {
  const std::string said = last_message();
  if (_writing) throw failure("cannot write the database " + _path.string() + " (" + what + ")", said, not_written);
  throw input_error("cannot read the database " + _path.string() + " (" + what + ")", said, damaged);
}

File File::create(const std::filesystem::path& path, std::uint64_t bytes) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  std::error_code none;
  std::filesystem::remove(path, none);  // what another run has left
  reserve_room(path, 0, bytes + margin_bytes);
  File file({}, path, true);
  // Unlike older formats, the 1.10 format has checksums of all metadata; fletcher32 protects the data.
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  file.check(access.id(), "creating the file");
  file.check(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V110, H5F_LIBVER_V110), "creating the file");
  const Handle creation = without_times(H5P_FILE_CREATE);
  file._file = Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access.id()), H5Fclose);
  file.check(file._file.id(), "creating the file");
  return file;
}

void File::reserve(std::uint64_t bytes) {
  hsize_t end = 0;
  check(H5Fget_filesize(_file.id(), &end), "asking for the size of the file");
  reserve_room(_path, end, bytes + margin_bytes);
}

File File::create_in_memory() {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  File file({}, "in memory", true);
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t growth = 1 << 20;
  file.check(H5Pset_fapl_core(access.id(), growth, false), "choosing the file driver");
  file._file = Handle(H5Fcreate("in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access.id()), H5Fclose);
  file.check(file._file.id(), "creating the file");
  return file;
}

File::~File() {
  _datasets.clear();
  _file.close();
}

void File::close() {
  if (_file.id() < 0) return;
  _datasets.clear();
  if (_writing) check(H5Fflush(_file.id(), H5F_SCOPE_GLOBAL), "flushing the file");
  check(_file.close(), "closing the file");
}

void File::create_group(const std::string& name) {
  const Handle properties = without_times(H5P_GROUP_CREATE);
  Handle group(H5Gcreate2(_file.id(), name.c_str(), H5P_DEFAULT, properties.id(), H5P_DEFAULT), H5Gclose);
  check(group.id(), name);
}

void File::create_dataset(const std::string& name, hid_t stored_type, const Shape& shape, const Shape& chunk,
                          const std::string& unit, const std::string& description) {
  const Handle space(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
  check(space.id(), name);
  const Handle properties = without_times(H5P_DATASET_CREATE);
  check(properties.id(), name);
  if (!chunk.empty()) {
    // For floating-point data, levels above 2 take several times the CPU time and save only a few per cent.
    constexpr unsigned deflate_level = 2;
    check(H5Pset_chunk(properties.id(), static_cast<int>(chunk.size()), chunk.data()), name);
    check(H5Pset_shuffle(properties.id()), name);
    check(H5Pset_deflate(properties.id(), deflate_level), name);
    check(H5Pset_fletcher32(properties.id()), name);
  }
  const Handle dataset(
      H5Dcreate2(_file.id(), name.c_str(), stored_type, space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
      H5Dclose);
  check(dataset.id(), name);
  write_attribute(name, "unit", unit);
  write_attribute(name, "description", description);
}

void File::write_slab_raw(const std::string& name, hsize_t first, hsize_t count, hid_t type, const void* values) {
  Handle dataset(H5Dopen2(_file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  check(dataset.id(), name);
  const Handle space(H5Dget_space(dataset.id()), H5Sclose);
  Shape extent(static_cast<std::size_t>(check(H5Sget_simple_extent_ndims(space.id()), name)));
  check(H5Sget_simple_extent_dims(space.id(), extent.data(), nullptr), name);
  Shape start(extent.size(), 0);
  extent[0] = count;
  start[0] = first;
  check(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr), name);
  const Handle memory(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
  check(H5Dwrite(dataset.id(), type, memory.id(), space.id(), H5P_DEFAULT, values),
        name + ", entry " + std::to_string(first));
  check(dataset.close(), name);
}

std::uint32_t File::read_chunk(const Chunk& chunk, std::vector<unsigned char>& bytes) const {
  const Handle dataset(H5Dopen2(_file.id(), chunk.dataset.c_str(), H5P_DEFAULT), H5Dclose);
  check(dataset.id(), chunk.dataset);
  hsize_t size = 0;
  check(H5Dget_chunk_storage_size(dataset.id(), chunk.first.data(), &size), chunk.dataset);
  const auto end = bytes.size();
  bytes.resize(end + size);
  std::uint32_t filter_mask = 0;
  check(H5Dread_chunk(dataset.id(), H5P_DEFAULT, chunk.first.data(), &filter_mask, bytes.data() + end), chunk.dataset);
  return filter_mask;
}

void File::write_chunk(const Chunk& chunk, const unsigned char* bytes, std::size_t size, std::uint32_t filter_mask) {
  Handle dataset(H5Dopen2(_file.id(), chunk.dataset.c_str(), H5P_DEFAULT), H5Dclose);
  check(dataset.id(), chunk.dataset);
  check(H5Dwrite_chunk(dataset.id(), H5P_DEFAULT, filter_mask, chunk.first.data(), size, bytes), chunk.dataset);
  check(dataset.close(), chunk.dataset);
}

void File::write_attribute_raw(const std::string& object, const std::string& name, hid_t stored, hid_t memory,
                               const Handle& space, const void* values) {
  const Handle attribute(H5Acreate_by_name(_file.id(), object.c_str(), name.c_str(), stored, space.id(), H5P_DEFAULT,
                                           H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  check(attribute.id(), name);
  check(H5Awrite(attribute.id(), memory, values), name);
}

void File::write_attribute(const std::string& object, const std::string& name, const std::string& text) {
  const Handle type = text_type();
  const char* value = text.c_str();
  write_attribute_raw(object, name, type.id(), type.id(), scalar_space(), &value);
}

void File::write_attribute(const std::string& object, const std::string& name, const std::vector<std::int8_t>& values) {
  const hsize_t size = values.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose);
  write_attribute_raw(object, name, H5T_STD_I8LE, H5T_NATIVE_INT8, space, values.data());
}

void File::write_attribute(const std::string& object, const std::string& name, std::int32_t value) {
  write_attribute_raw(object, name, H5T_STD_I32LE, H5T_NATIVE_INT32, scalar_space(), &value);
}

void File::write_text(const std::string& name, const std::string& text, const std::string& description) {
  const Handle type = text_type(), space = scalar_space(), properties = without_times(H5P_DATASET_CREATE);
  Handle dataset(H5Dcreate2(_file.id(), name.c_str(), type.id(), space.id(), H5P_DEFAULT, properties.id(), H5P_DEFAULT),
                 H5Dclose);
  check(dataset.id(), name);
  const char* value = text.c_str();
  check(H5Dwrite(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, &value), name);
  check(dataset.close(), name);
  write_attribute(name, "unit", "1");
  write_attribute(name, "description", description);
}

}  // namespace phynness::hdf5
