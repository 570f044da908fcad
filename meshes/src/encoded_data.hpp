// Binary data in VTK's XML files: raw or base64, preceded by sizes, with or without zlib compression.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace phynness::meshes {

/// A defect of the data, without the file and the place, which the caller adds.
struct EncodedDataError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct DataEncoding {
  bool big_endian = false;
  int header_bytes = 4;  ///< length of each size before the data
  bool zlib = false;
};

/// Decodes the data at the beginning of `text`.
/// @param base64      true: the text is base64; false: the text is the bytes
/// @param most_bytes  larger data are refused before any allocation
/// @throws EncodedDataError
std::string decoded_data(std::string_view text, bool base64, const DataEncoding& encoding, std::uint64_t most_bytes);

}  // namespace phynness::meshes
