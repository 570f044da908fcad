// Interface of the fuzz targets: seeds, a function that takes an input, and checks that end the program. It is called
// by libFuzzer (libfuzzer_entry.cpp), or by a main with fixed random numbers (plain_main.cpp), which needs no clang.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace phynness::fuzz {

using Input = std::vector<std::uint8_t>;

/// Inputs to start from; each target defines it.
std::vector<Input> seeds();

inline void require(bool condition, const char* claim) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", claim);
  std::abort();
}

/// Repeatable random numbers (Steele, Lea, Flood 2014, splitmix64).
class Random {
 public:
  explicit Random(std::uint64_t seed) : _state(seed) {}
  std::uint64_t next() {
    std::uint64_t z = _state += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  /// 0 ... n - 1; 0 for n = 0
  std::size_t below(std::size_t n) { return n == 0 ? 0 : next() % n; }

 private:
  std::uint64_t _state;
};

/// Random bytes behind one that counts the inputs, modulo `first`.
inline std::vector<Input> random_inputs(std::uint64_t seed, int n, int n_bytes, int first = 256) {
  std::vector<Input> all;
  Random random(seed);
  for (int i = 0; i < n; ++i) {
    Input& input = all.emplace_back(1, static_cast<std::uint8_t>(i % first));
    for (int k = 0; k < n_bytes; ++k) input.push_back(static_cast<std::uint8_t>(random.next()));
  }
  return all;
}

/// Bytes read as choices and numbers; zeros after their end.
class Script {
 public:
  Script(const std::uint8_t* data, std::size_t size) : _data(data), _size(size) {}
  explicit Script(const Input& input) : Script(input.data(), input.size()) {}

  bool at_end() const { return _at >= _size; }
  std::uint8_t byte() { return _at < _size ? _data[_at++] : 0; }
  int below(int n) { return n > 0 ? byte() % n : 0; }
  template <class T>
  T raw() {
    T value{};
    const std::size_t n = std::min(sizeof value, _size - std::min(_at, _size));
    std::memcpy(&value, _data + _at, n);
    _at += n;
    return value;
  }
  /// Of any size and kind: special values, any bit pattern, centimetres.
  double number() {
    using Limits = std::numeric_limits<double>;
    constexpr double inf = Limits::infinity(), nan = Limits::quiet_NaN(), tiny = Limits::min(), huge = Limits::max();
    constexpr double special[] = {0,      -0.0,  1,     -1,     0.01,   -0.01,  1e-6, 1e6,  1e30,  -1e30, 1e100, -1e100,
                                  1e-100, 1e155, 1e200, -1e300, 1e-300, 5e-324, tiny, huge, -huge, inf,   -inf,  nan};
    const int kind = byte();
    if (kind < 64) return special[static_cast<std::size_t>(kind) % std::size(special)];
    if (kind < 96) return std::bit_cast<double>(raw<std::uint64_t>());
    return raw<std::int16_t>() / 32768.0 * (kind < 224 ? 0.02 : 10);
  }
  Input rest() const { return {_data + std::min(_at, _size), _data + _size}; }

 private:
  const std::uint8_t* _data;
  std::size_t _size, _at = 0;
};

/// Appends the bytes of values to an input.
template <class... Values>
void append(Input& input, const Values&... values) {
  const auto one = [&input](const auto& value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    input.insert(input.end(), bytes, bytes + sizeof value);
  };
  (one(values), ...);
}
inline void append_text(Input& input, std::string_view text) { input.insert(input.end(), text.begin(), text.end()); }

}  // namespace phynness::fuzz

extern "C" {
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);
/// Changes bytes at random; libFuzzer's, or that of plain_main.cpp.
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed);
}
