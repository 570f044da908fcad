// Binary data inside of VTK's XML files: raw or base64, with the sizes before it, compressed by zlib or not.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace phynness::meshes {

/// What is wrong with the data; the caller knows the file and the place.
struct EncodedDataError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct DataEncoding {
  bool big_endian = false;
  int header_bytes = 4;  ///< of each size before the data
  bool zlib = false;
};

/// The bytes that `text` holds from its beginning on.
/// @param base64      the text is base64, else the bytes themselves
/// @param most_bytes  more are refused before they are allocated
/// @throws EncodedDataError
std::string decoded_data(std::string_view text, bool base64, const DataEncoding& encoding, std::uint64_t most_bytes);

}  // namespace phynness::meshes
