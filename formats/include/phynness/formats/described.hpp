// Results describe themselves: describe(result, see) calls see(key, value) for each figure, in the order of the JSON,
// and see(key, value, title) for those that tables show under this title. JSON (figures.hpp) and tables follow from it.
#pragma once

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace phynness {

/// A number that is not defined: null in JSON, "-" in tables.
inline constexpr double undefined = std::numeric_limits<double>::quiet_NaN();

/// Results with keys of their own.
template <class T>
using ByName = std::vector<std::pair<std::string, T>>;

// For members whose names are the keys: PHYNNESS_SEE(a, b) stands for see("a", result.a), see("b", result.b) in a
// describe(result, see), and PHYNNESS_FIGURES(a, b) for all of it.
#define PHYNNESS_SEE(...) __VA_OPT__(PHYNNESS_SCAN(PHYNNESS_SEE_FIRST(__VA_ARGS__)))
#define PHYNNESS_SEE_FIRST(name, ...) \
  see(#name, result.name) __VA_OPT__(, PHYNNESS_SEE_REST PHYNNESS_LATER(__VA_ARGS__))
#define PHYNNESS_SEE_REST() PHYNNESS_SEE_FIRST
#define PHYNNESS_LATER ()
#define PHYNNESS_SCAN(...) PHYNNESS_SCAN_3(PHYNNESS_SCAN_3(PHYNNESS_SCAN_3(__VA_ARGS__)))
#define PHYNNESS_SCAN_3(...) PHYNNESS_SCAN_9(PHYNNESS_SCAN_9(PHYNNESS_SCAN_9(__VA_ARGS__)))
#define PHYNNESS_SCAN_9(...) PHYNNESS_SCAN_1(PHYNNESS_SCAN_1(PHYNNESS_SCAN_1(__VA_ARGS__)))
#define PHYNNESS_SCAN_1(...) __VA_ARGS__
#define PHYNNESS_FIGURES(...) \
  static void describe(const auto& result, auto&& see) { PHYNNESS_SEE(__VA_ARGS__); }

template <class T>
concept Described = requires(const T& result) {
  T::describe(result, [](auto&&...) {});
};

}  // namespace phynness
