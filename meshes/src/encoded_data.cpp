#include "encoded_data.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <vector>

namespace phynness::meshes {
namespace {

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// A cursor over bytes, or over base64. Parts that were encoded one after the other, each with its own padding, are one
/// sequence of bytes.
class ByteStream {
 public:
  ByteStream(std::string_view text, bool base64) : _text(text), _base64(base64) {}

  /// No more bytes than this are left.
  std::uint64_t at_most() const { return _text.size() - _at + _held.size(); }

  std::string take(std::uint64_t n) {
    if (n > at_most()) throw EncodedDataError("it ends too early");
    if (!_base64) {
      _at += n;
      return std::string(_text.substr(_at - n, n));
    }
    std::string bytes = std::move(_held);
    _held.clear();
    bytes.reserve(n + 3);
    while (bytes.size() < n) append_quad(bytes);
    _held = bytes.substr(n);
    bytes.resize(n);
    return bytes;
  }

 private:
  void append_quad(std::string& bytes) {
    std::array<int, 4> values{};
    int n = 0, padding = 0;
    while (n < 4) {
      if (_at == _text.size()) throw EncodedDataError("it ends too early");
      const char c = _text[_at++];
      if (c == ' ' || c == '\t' || c == '\n' || c == '\r') continue;
      if (c == '=' && n >= 2) {
        ++padding, ++n;
        continue;
      }
      values[n] = base64_value(c);
      if (values[n++] < 0 || padding > 0) throw EncodedDataError("it holds characters that are not base64");
    }
    const int word = values[0] << 18 | values[1] << 12 | values[2] << 6 | values[3];
    for (int k = 0; k < 3 - padding; ++k) bytes += static_cast<char>(word >> (16 - 8 * k) & 255);
  }

  std::string_view _text;
  std::size_t _at = 0;
  bool _base64;
  std::string _held;  ///< decoded and not yet taken
};

std::uint64_t size_at(const std::string& bytes, std::size_t index, const DataEncoding& encoding) {
  const auto width = static_cast<std::size_t>(encoding.header_bytes);
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < width; ++k) {
    const std::size_t at = index * width + (encoding.big_endian ? k : width - 1 - k);
    value = value << 8 | static_cast<unsigned char>(bytes[at]);
  }
  return value;
}

void require_at_most(std::uint64_t bytes, std::uint64_t most_bytes) {
  if (bytes > most_bytes)
    throw EncodedDataError("it holds " + std::to_string(bytes) + " bytes, more than the " + std::to_string(most_bytes) +
                           " bytes of the numbers that are declared");
}

void append_uncompressed(std::string& bytes, const std::string& block, std::uint64_t size) {
  const std::size_t before = bytes.size();
  bytes.resize(before + size);
  auto length = static_cast<uLongf>(size);
  const int code = uncompress(reinterpret_cast<Bytef*>(bytes.data() + before), &length,
                              reinterpret_cast<const Bytef*>(block.data()), static_cast<uLong>(block.size()));
  if (code != Z_OK || length != size) throw EncodedDataError("a compressed block of it is damaged");
}

std::string decompressed(ByteStream& stream, const DataEncoding& encoding, std::uint64_t most_bytes) {
  const auto width = static_cast<std::uint64_t>(encoding.header_bytes);
  const std::uint64_t n_blocks = size_at(stream.take(width), 0, encoding);
  if (n_blocks > stream.at_most() / width) throw EncodedDataError("it declares more blocks than it holds");
  const std::string header = stream.take((n_blocks + 2) * width);
  const std::uint64_t block_size = size_at(header, 0, encoding), last = size_at(header, 1, encoding);
  require_at_most(block_size, std::max(most_bytes, std::uint64_t{1} << 20));  // of small data a part of a block is used
  require_at_most(last, most_bytes);
  std::string bytes;
  for (std::uint64_t b = 0; b < n_blocks; ++b) {
    const std::uint64_t size = b + 1 == n_blocks && last > 0 ? last : block_size;
    require_at_most(bytes.size() + size, most_bytes);
    append_uncompressed(bytes, stream.take(size_at(header, b + 2, encoding)), size);
  }
  return bytes;
}

}  // namespace

std::string decoded_data(std::string_view text, bool base64, const DataEncoding& encoding, std::uint64_t most_bytes) {
  ByteStream stream(text, base64);
  if (encoding.zlib) return decompressed(stream, encoding, most_bytes);
  const std::uint64_t size = size_at(stream.take(static_cast<std::uint64_t>(encoding.header_bytes)), 0, encoding);
  require_at_most(size, most_bytes);
  return stream.take(size);
}

}  // namespace phynness::meshes
