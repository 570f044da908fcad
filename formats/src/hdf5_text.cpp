#include "hdf5_text.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "hdf5_heapless_driver.hpp"

namespace phynness::hdf5 {
namespace {

static_assert(std::endian::native == std::endian::little,
              "HDF5 files are little-endian; byte swaps for this host are not implemented");

constexpr std::uint64_t heap_header_bytes = 16;    // signature, version, 3 reserved bytes, size
constexpr std::uint64_t object_header_bytes = 16;  // index, reference count, 4 reserved bytes, size
constexpr unsigned char heap_version = 1;

template <class T>
T value_at(const unsigned char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// A conversion that keeps the bytes unchanged.
herr_t keep_bytes(hid_t from, hid_t to, H5T_cdata_t* conversion, std::size_t, std::size_t, std::size_t, void*, void*,
                  hid_t) {
  if (conversion->command != H5T_CONV_INIT) return 0;
  conversion->need_bkg = H5T_BKG_NO;
  const bool fits =
      H5Tis_variable_str(from) > 0 && H5Tget_size(from) == text_place_bytes && H5Tget_size(to) == text_place_bytes;
  return fits ? 0 : -1;
}

bool can_convert() {
  static const bool registered = [] {
    const Handle text(H5Tcopy(H5T_C_S1), H5Tclose), bytes(H5Tcreate(H5T_OPAQUE, text_place_bytes), H5Tclose);
    return H5Tset_size(text.id(), H5T_VARIABLE) >= 0 &&
           H5Tregister(H5T_PERS_SOFT, "phynness_text_place", text.id(), bytes.id(), keep_bytes) >= 0;
  }();
  return registered;
}

std::string numbers(std::uint64_t at, std::uint64_t size) {
  return std::to_string(size) + " bytes at " + std::to_string(at);
}

}  // namespace

Handle text_place_type() {
  if (!can_convert()) return {};
  return {H5Tcreate(H5T_OPAQUE, text_place_bytes), H5Tclose};
}

TextPlace text_place(const unsigned char (&bytes)[text_place_bytes]) {
  return {value_at<std::uint32_t>(bytes), value_at<std::uint64_t>(bytes + 4), value_at<std::uint32_t>(bytes + 12)};
}

bool read_text_at(const Descriptor& file, const std::filesystem::path& path, std::uint64_t bytes_of_file,
                  const TextPlace& place, std::string& text, std::string& defect) {
  text.clear();
  if (place.length == 0) return true;
  const auto wrong = [&](const std::string& what) {
    defect = what;
    return false;
  };
  if (place.heap > bytes_of_file || bytes_of_file - place.heap < heap_header_bytes)
    return wrong("its heap is beyond the end of the file: address " + std::to_string(place.heap));
  unsigned char header[heap_header_bytes];
  if (read_at(file, path, static_cast<std::int64_t>(place.heap), header, sizeof header) < sizeof header)
    return wrong("its heap is beyond the end of the file");
  const auto size = value_at<std::uint64_t>(header + 8);
  if (std::memcmp(header, heap_signature, sizeof heap_signature) != 0 || header[4] != heap_version)
    return wrong("there is no heap at its address " + std::to_string(place.heap));
  if (size < heap_header_bytes || size > bytes_of_file - place.heap || size > most_text_bytes)
    return wrong("its heap has an impossible size: " + numbers(place.heap, size));

  std::vector<unsigned char> heap(size);
  if (read_at(file, path, static_cast<std::int64_t>(place.heap), heap.data(), heap.size()) < heap.size())
    return wrong("its heap is beyond the end of the file");
  for (std::uint64_t at = heap_header_bytes; size - at >= object_header_bytes;) {
    const auto index = value_at<std::uint16_t>(&heap[at]);
    const auto length = value_at<std::uint64_t>(&heap[at + 8]);
    if (index == 0) break;  // free space, which is the last object of a heap
    at += object_header_bytes;
    if (length > size - at) return wrong("its heap is damaged: an object of " + numbers(place.heap + at, length));
    if (index == place.index) {
      if (length != place.length)
        return wrong("its heap has " + std::to_string(length) + " bytes for a text of " + std::to_string(place.length));
      text.assign(reinterpret_cast<const char*>(&heap[at]), length);
      return true;
    }
    constexpr std::uint64_t alignment = 8;
    at += std::min((length + alignment - 1) / alignment * alignment, size - at);
  }
  return wrong("it is not in its heap: object " + std::to_string(place.index));
}

}  // namespace phynness::hdf5
