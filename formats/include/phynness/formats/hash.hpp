// The hash of all formats: 64-bit FNV-1a (Fowler, Noll, Vo), which any reader of the formats can easily implement.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace phynness {

class Fnv1a64 {
 public:
  void add(const void* bytes, std::size_t n) noexcept {
    const auto* p = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < n; ++i) _state = (_state ^ p[i]) * 0x100000001b3ULL;
  }
  void add(std::string_view text) noexcept { add(text.data(), text.size()); }
  std::uint64_t value() const noexcept { return _state; }
  /// 16 lower-case hexadecimal digits.
  std::string hex() const {
    std::string s(16, '0');
    for (int i = 0; i < 16; ++i) s[15 - i] = "0123456789abcdef"[(_state >> (4 * i)) & 15];
    return s;
  }

 private:
  std::uint64_t _state = 0xcbf29ce484222325ULL;
};

/// hex() of a text.
inline std::string hash_of(std::string_view text) {
  Fnv1a64 hash;
  hash.add(text);
  return hash.hex();
}

}  // namespace phynness
