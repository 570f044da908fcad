// Divides the caller's memory into arrays. Without memory it only counts bytes, so that the _size and _init functions
// share their code.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/arithmetic.hpp"

namespace PHN_RUNTIME {

// Not inline, because about seventy callers would each contain a copy.
#ifdef __GNUC__
#define PHN_OUT_OF_LINE inline __attribute__((noinline))
#else
#define PHN_OUT_OF_LINE inline
#endif

/// Arrays of at least this many bytes start at a cache line. Smaller arrays, of which a model has thousands, are packed
/// without gaps.
inline constexpr std::size_t alignment = 64, smallest_aligned = 1024;

class Arena {
 public:
  /// Only counts bytes.
  Arena() = default;
  /// @param memory  any alignment
  Arena(void* memory, std::size_t bytes) {
    const std::size_t off = reinterpret_cast<std::uintptr_t>(memory) % alignment;
    const std::size_t skipped = off == 0 ? 0 : alignment - off;
    _base = static_cast<unsigned char*>(memory) + skipped;
    _bytes = bytes > alignment - 1 ? bytes - (alignment - 1) : 0;  // less than needed() is refused at any alignment
  }

  /// `n` x `per` objects of T, uninitialized; null when counting or when the memory is used up.
  template <class T>
  T* take(std::size_t n, std::size_t per = 1) {
    return static_cast<T*>(take(n, per, sizeof(T), alignof(T)));
  }

  bool counting() const { return _base == nullptr; }
  /// Whether the memory was too small or, when counting, the size exceeds the largest possible one.
  bool overflow() const { return _overflow; }
  /// Bytes from the first array to the end of the last.
  std::size_t used() const { return _used; }
  /// Bytes of memory that suffice for any alignment of its start.
  std::size_t needed() const { return _used + alignment - 1; }

 private:
  /// Half of the address range, so that the sum of the used bytes and a further array cannot wrap around, even with
  /// 32-bit addresses.
  static constexpr std::size_t largest = static_cast<std::size_t>(PTRDIFF_MAX) - 2 * alignment;

  void* take(std::size_t n, std::size_t per, std::size_t size, std::size_t align);

  unsigned char* _base = nullptr;
  std::size_t _bytes = 0, _used = 0;
  bool _overflow = false;
};

PHN_OUT_OF_LINE void* Arena::take(std::size_t n, std::size_t per, std::size_t size, std::size_t align) {
  if (_overflow) return nullptr;
  const bool fits = per == 0 || n <= largest / size / per;
  const std::size_t bytes = fits ? n * per * size : 0;
  if (bytes >= smallest_aligned) align = alignment;
  const std::size_t at = (_used + align - 1) / align * align;
  if (!fits || at > largest || bytes > largest - at || (_base != nullptr && at + bytes > _bytes)) {
    _overflow = true;
    return nullptr;
  }
  _used = at + bytes;
  return _base == nullptr ? nullptr : _base + at;
}

}  // namespace PHN_RUNTIME
