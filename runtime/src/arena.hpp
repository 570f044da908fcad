// Hands out pieces of the caller's memory; without memory it only counts, so size and init walk the same
// path.
#pragma once

#include <cstddef>
#include <cstdint>

#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// Arrays of at least this many bytes start at a cache line; smaller ones, of which a model has thousands,
/// are packed.
inline constexpr std::size_t alignment = 64, smallest_aligned = 1024;

class Arena {
 public:
  /// Counts what would be taken.
  Arena() = default;
  /// @param memory  any alignment
  Arena(void* memory, std::size_t bytes) {
    const std::size_t off = reinterpret_cast<std::uintptr_t>(memory) % alignment;
    const std::size_t skipped = off == 0 ? 0 : alignment - off;
    _base = static_cast<unsigned char*>(memory) + skipped;
    _bytes = bytes > skipped ? bytes - skipped : 0;
  }

  /// `n` x `per` objects of T, uninitialized; null when counting or when the memory is used up.
  template <class T>
  T* take(std::size_t n, std::size_t per = 1) {
    return static_cast<T*>(take(n, per, sizeof(T), alignof(T)));
  }

  bool counting() const { return _base == nullptr; }
  /// Whether the memory was used up, or when counting: more than any memory has.
  bool overflow() const { return _overflow; }
  /// Bytes of what was taken, from the first of it on.
  std::size_t used() const { return _used; }
  /// Bytes to ask for, whatever the alignment of the memory will be.
  std::size_t needed() const { return _used + alignment - 1; }

 private:
  /// Half of what addresses can tell: sums of an array and what was taken before do not wrap, on devices of 32 bits
  /// neither.
  static constexpr std::size_t largest = static_cast<std::size_t>(PTRDIFF_MAX) - 2 * alignment;

  /// Not in the header: it is called some seventy times.
  void* take(std::size_t n, std::size_t per, std::size_t size, std::size_t align);

  unsigned char* _base = nullptr;
  std::size_t _bytes = 0, _used = 0;
  bool _overflow = false;
};

}  // namespace PHN_RUNTIME
