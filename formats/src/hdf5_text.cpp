// Texts of variable length, read without HDF5's own code. A file stores the length of such a text, the address of a
// global heap, and an index in this heap; see "Global Heap" in HDF5's file format specification. A heap has no
// checksum, and HDF5 1.10 does not validate it: a zeroed block causes an infinite loop, and wrong sizes cause copies
// beyond buffers.
#include "hdf5_file.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

namespace phynness::hdf5 {
namespace {

constexpr char heap_signature[] = {'G', 'C', 'O', 'L'};
constexpr std::uint64_t heap_header_bytes = 16;    // signature, version, 3 reserved bytes, size
constexpr std::uint64_t object_header_bytes = 16;  // index, reference count, 4 reserved bytes, size
constexpr unsigned char heap_version = 1;

/// A conversion that keeps the bytes unchanged.
herr_t keep_bytes(hid_t from, hid_t to, H5T_cdata_t* conversion, std::size_t, std::size_t, std::size_t, void*, void*,
                  hid_t) {
  if (conversion->command != H5T_CONV_INIT) return 0;
  conversion->need_bkg = H5T_BKG_NO;
  const bool fits =
      H5Tis_variable_str(from) > 0 && H5Tget_size(from) == text_place_bytes && H5Tget_size(to) == text_place_bytes;
  return fits ? 0 : -1;
}

std::string numbers(std::uint64_t at, std::uint64_t size) {
  return std::to_string(size) + " bytes at " + std::to_string(at);
}

}  // namespace

Handle text_place_type() {
  static const bool can_convert = [] {
    const Handle text(H5Tcopy(H5T_C_S1), H5Tclose), bytes(H5Tcreate(H5T_OPAQUE, text_place_bytes), H5Tclose);
    return H5Tset_size(text.id(), H5T_VARIABLE) >= 0 &&
           H5Tregister(H5T_PERS_SOFT, "phynness_text_place", text.id(), bytes.id(), keep_bytes) >= 0;
  }();
  if (!can_convert) return {};
  return {H5Tcreate(H5T_OPAQUE, text_place_bytes), H5Tclose};
}

std::string read_text_at(const Descriptor& file, const std::filesystem::path& path, std::uint64_t bytes_of_file,
                         const unsigned char (&place)[text_place_bytes], std::string& text) {
  const auto length_of_text = value_at<std::uint32_t>(place), wanted = value_at<std::uint32_t>(place + 12);
  const auto address = value_at<std::uint64_t>(place + 4);
  text.clear();
  if (length_of_text == 0) return "";
  unsigned char header[heap_header_bytes];
  if (address > bytes_of_file ||
      read_at(file, path, static_cast<std::int64_t>(address), header, sizeof header) < sizeof header)
    return "its heap is beyond the end of the file: address " + std::to_string(address);
  const auto size = value_at<std::uint64_t>(header + 8);
  if (std::memcmp(header, heap_signature, sizeof heap_signature) != 0 || header[4] != heap_version)
    return "there is no heap at its address " + std::to_string(address);
  if (size < heap_header_bytes || size > bytes_of_file - address || size > most_text_bytes)
    return "its heap has an impossible size: " + numbers(address, size);

  std::vector<unsigned char> heap(size);
  if (read_at(file, path, static_cast<std::int64_t>(address), heap.data(), heap.size()) < heap.size())
    return "its heap is beyond the end of the file";
  for (std::uint64_t at = heap_header_bytes; size - at >= object_header_bytes;) {
    const auto index = value_at<std::uint16_t>(&heap[at]);
    const auto length = value_at<std::uint64_t>(&heap[at + 8]);
    if (index == 0) break;  // free space, which is the last object of a heap
    at += object_header_bytes;
    if (length > size - at) return "its heap is damaged: an object of " + numbers(address + at, length);
    if (index == wanted) {
      if (length != length_of_text)
        return "its heap has " + std::to_string(length) + " bytes for a text of " + std::to_string(length_of_text);
      text.assign(reinterpret_cast<const char*>(&heap[at]), length);
      return "";
    }
    constexpr std::uint64_t alignment = 8;
    at += std::min((length + alignment - 1) / alignment * alignment, size - at);
  }
  return "it is not in its heap: object " + std::to_string(wanted);
}

}  // namespace phynness::hdf5
