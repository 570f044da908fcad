#include "hdf5_checks.hpp"

#include <limits>

namespace phynness::hdf5 {
namespace {

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

}  // namespace

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

bool read_shape(hid_t space, Shape& shape) {
  shape.clear();
  const auto kind = H5Sget_simple_extent_type(space);
  if (kind == H5S_SCALAR) return true;
  const int rank = H5Sget_simple_extent_ndims(space);
  if (kind != H5S_SIMPLE || rank < 0) return false;
  shape.resize(static_cast<std::size_t>(rank));
  return H5Sget_simple_extent_dims(space, shape.data(), nullptr) == rank;
}

std::uint64_t number_of_values(const Shape& shape) {
  constexpr std::uint64_t most = std::numeric_limits<std::int64_t>::max();
  std::uint64_t number = 1;
  for (const auto n : shape) number = n != 0 && number > most / n ? most : number * n;
  return number;
}

std::string text(const Shape& shape) {
  if (shape.empty()) return "one value";
  std::string text = "[";
  for (std::size_t i = 0; i < shape.size(); ++i) text += (i ? ", " : "") + std::to_string(shape[i]);
  return text + "]";
}

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

}  // namespace phynness::hdf5
