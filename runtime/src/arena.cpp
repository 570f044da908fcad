#include "arena.hpp"

namespace PHN_RUNTIME {

void* Arena::take(std::size_t n, std::size_t per, std::size_t size, std::size_t align) {
  if (_overflow) return nullptr;
  const bool told = per == 0 || n <= largest / size / per;
  const std::size_t bytes = told ? n * per * size : 0;
  if (bytes >= smallest_aligned) align = alignment;
  const std::size_t at = (_used + align - 1) / align * align;
  if (!told || at > largest || bytes > largest - at || (_base != nullptr && at + bytes > _bytes)) {
    _overflow = true;
    return nullptr;
  }
  _used = at + bytes;
  return _base == nullptr ? nullptr : _base + at;
}

}  // namespace PHN_RUNTIME
