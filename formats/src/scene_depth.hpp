// How deep the tables and arrays of a TOML text are nested.
#pragma once

#include <optional>
#include <string_view>

namespace phynness::scene_detail {

/// Parts of keys, [headers] and open brackets, one inside of the other. Scenes need five.
inline constexpr int largest_depth = 64;

/// The line (from 1) where a text is nested deeper than largest_depth; none if it is not.
/// A parser and its tables call themselves once for each level, so that 20,000 levels end the program: toml++
/// limits brackets, not keys. Dots and brackets in strings and comments do not count. A text that is not TOML
/// may pass.
std::optional<int> too_deep_at(std::string_view text);

}  // namespace phynness::scene_detail
