#include "hdf5_checks.hpp"

#include <algorithm>
#include <limits>

namespace phynness::hdf5 {
namespace {

constexpr std::uint64_t limit = std::numeric_limits<std::int64_t>::max();

/// The product, or `limit` if the product is larger.
std::uint64_t product(std::uint64_t a, std::uint64_t b) { return b != 0 && a > limit / b ? limit : a * b; }

std::uint64_t size_of(const Shape& shape, std::size_t bytes_per_value) {
  // A shape with a zero has no values. Without this test a product of the other extents could overflow.
  if (std::find(shape.begin(), shape.end(), hsize_t{0}) != shape.end()) return 0;
  std::uint64_t size = bytes_per_value;
  for (const auto n : shape) size = product(size, n);
  return size;
}

/// "/a/b/c": "/a", "/a/b", "/a/b/c"
std::vector<std::string> steps_of(const std::string& path) {
  std::vector<std::string> steps;
  for (std::size_t at = 1; at < path.size();) {
    at = std::min(path.find('/', at), path.size());
    steps.push_back(path.substr(0, at++));
  }
  return steps;
}

std::string filter_defect(hid_t properties) {
  const int n = H5Pget_nfilters(properties);
  if (n < 0) return "its filters cannot be read";
  for (int i = 0; i < n; ++i) {
    unsigned flags = 0, settings = 0;
    std::size_t n_values = 0;
    const auto filter =
        H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &n_values, nullptr, 0, nullptr, &settings);
    if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_FLETCHER32)
      return "it is compressed by a filter that databases do not use: number " + std::to_string(filter);
  }
  return "";
}

std::string chunk_defect(hid_t dataset, hid_t properties, const Shape& shape, std::size_t bytes_per_value,
                         std::uint64_t bytes_of_file) {
  // Deflate makes 1032 bytes of one at most.
  constexpr std::uint64_t largest_ratio = 1032;
  Shape chunk(shape.size());
  if (H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data()) != static_cast<int>(shape.size()))
    return "its chunks have another rank";
  std::uint64_t wanted = 1;
  for (std::size_t k = 0; k < shape.size(); ++k) {
    if (chunk[k] == 0) return "its chunks are empty";
    wanted = product(wanted, (shape[k] - 1) / chunk[k] + 1);
  }
  const auto bytes = size_of(shape, bytes_per_value);
  const auto tell = [&](std::uint64_t room) {
    return text(shape) + " needs " + std::to_string(bytes) + " bytes, but " + std::to_string(room) + " are stored";
  };
  // The number of chunks is bounded first, because HDF5 reads all chunks to count them.
  if (wanted > bytes_of_file || bytes / largest_ratio > bytes_of_file ||
      size_of(chunk, bytes_per_value) / largest_ratio > bytes_of_file)
    return tell(bytes_of_file);
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  if (stored > bytes_of_file || bytes / largest_ratio > stored) return tell(stored);
#if H5_VERSION_GE(1, 10, 5)
  const Handle space(H5Dget_space(dataset), H5Sclose);
  hsize_t written = 0;
  if (H5Dget_num_chunks(dataset, space.id(), &written) < 0) return "its chunks cannot be counted";
  if (written != wanted) return std::to_string(written) + " of its " + std::to_string(wanted) + " chunks were written";
#endif
  return "";
}

}  // namespace

Handle open_own_object(hid_t file, const std::string& path, std::string& defect) {
  Handle object(H5Oopen(file, "/", H5P_DEFAULT), H5Oclose);
  for (const auto& step : steps_of(path)) {
    if (object.id() >= 0 && H5Iget_type(object.id()) != H5I_GROUP) {
      defect = "has a path that contains an object other than a group";
      return {};
    }
    H5L_info_t link;
    if (H5Lexists(file, step.c_str(), H5P_DEFAULT) <= 0 || H5Lget_info(file, step.c_str(), &link, H5P_DEFAULT) < 0) {
      defect = step == path ? "is missing" : "is missing: there is no " + step;
      return {};
    }
    if (link.type != H5L_TYPE_HARD) {
      defect = (step == path ? "is" : "is behind " + step + ",") + std::string(" a link to another place");
      return {};
    }
    Handle next(H5Oopen(file, step.c_str(), H5P_DEFAULT), H5Oclose);
    if (next.id() < 0) {
      defect = "cannot be opened; " + last_message();
      return {};
    }
    object = std::move(next);
  }
  if (object.id() < 0) defect = "cannot be opened; " + last_message();
  return object;
}

bool has_own_object(hid_t file, const std::string& path, std::string& defect) {
  for (const auto& step : steps_of(path)) {
    H5L_info_t link;
    if (H5Lexists(file, step.c_str(), H5P_DEFAULT) <= 0) return false;
    if (H5Lget_info(file, step.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD) {
      defect = (step == path ? "is" : "is behind " + step + ",") + std::string(" a link to another place");
      return false;
    }
  }
  return true;
}

std::string storage_defect(hid_t dataset, const Shape& shape, std::size_t bytes_per_value,
                           std::uint64_t bytes_of_file) {
  const Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (properties.id() < 0) return "its storage cannot be read";
  const auto layout = H5Pget_layout(properties.id());
  if (layout != H5D_COMPACT && layout != H5D_CONTIGUOUS && layout != H5D_CHUNKED)
    return "its values are in other datasets (a virtual dataset)";
  if (H5Pget_external_count(properties.id()) != 0) return "its values are in another file";
  if (auto defect = filter_defect(properties.id()); !defect.empty()) return defect;
  const auto bytes = size_of(shape, bytes_per_value);
  if (bytes == 0) return "";
  if (layout == H5D_CHUNKED) return chunk_defect(dataset, properties.id(), shape, bytes_per_value, bytes_of_file);
  const std::uint64_t stored = H5Dget_storage_size(dataset);
  if (stored != bytes || bytes > bytes_of_file)
    return text(shape) + " needs " + std::to_string(bytes) + " bytes, but " +
           std::to_string(std::min(stored, bytes_of_file)) + " are stored";
  // Without chunks there are no checksums, and a file with a hole in it can claim any size.
  constexpr std::uint64_t most_unchecked = 1 << 20;
  if (bytes > most_unchecked)
    return text(shape) + " is stored in one piece of " + std::to_string(bytes) + " bytes, not in chunks";
  return "";
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

std::uint64_t number_of_values(const Shape& shape) { return size_of(shape, 1); }

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
    case H5T_COMPOUND:
      return "a compound";
    case H5T_ENUM:
      return "an enumeration";
    case H5T_REFERENCE:
      return "a reference";
    case H5T_ARRAY:
      return "an array type";
    case H5T_VLEN:
      return "lists of variable length";
    default:
      return "an unknown type";
  }
}

bool is_plain_integer(hid_t type) {
  return H5Tget_class(type) == H5T_INTEGER && H5Tget_size(type) <= 8 && H5Tget_precision(type) == 8 * H5Tget_size(type);
}

}  // namespace phynness::hdf5
