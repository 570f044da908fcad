// Random numbers that are the same on every platform, which standard distributions do not guarantee.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace phynness {

/// SplitMix64 (Steele, Lea, Flood 2014, doi 10.1145/2660193.2660195).
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : _state(seed) {}

  std::uint64_t next() {
    _state += 0x9e3779b97f4a7c15ULL;
    std::uint64_t z = _state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  /// Uniform in 0 ... n - 1, n > 0. Draws that would favour small values are rejected.
  std::uint64_t below(std::uint64_t n) {
    const std::uint64_t unfair = (0 - n) % n;
    std::uint64_t draw = next();
    while (draw < unfair) draw = next();
    return draw % n;
  }

 private:
  std::uint64_t _state;
};

/// Seed of the draws of a node; draws of neighbouring seeds and nodes are independent.
inline std::uint64_t node_seed(std::uint64_t seed, std::int32_t node) {
  return SplitMix64(seed).next() ^ SplitMix64(~static_cast<std::uint64_t>(node)).next();
}

/// `count` distinct numbers of 0 ... n - 1 in random order (all of them if count >= n), by partial shuffling.
inline std::vector<std::int32_t> draw_without_replacement(std::size_t n, std::size_t count, SplitMix64& random) {
  std::vector<std::int32_t> numbers(n);
  std::iota(numbers.begin(), numbers.end(), 0);
  count = std::min(count, n);
  for (std::size_t i = 0; i < count; ++i) std::swap(numbers[i], numbers[i + random.below(n - i)]);
  numbers.resize(count);
  return numbers;
}

}  // namespace phynness
