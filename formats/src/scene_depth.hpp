// Nesting depth of the tables and arrays of a TOML text.
#pragma once

#include <optional>
#include <string_view>

namespace phynness::scene_detail {

/// Largest depth, counting parts of keys, [headers] and open brackets. Scenes need five levels.
inline constexpr int largest_depth = 64;

/// The first line (counted from 1) in which a text is nested deeper than largest_depth; empty if there is none. The
/// check is needed because the parser is recursive: 20,000 levels overflow the stack, and toml++ limits brackets but
/// not keys. Dots and brackets in strings and comments do not count. A text that is not valid TOML may pass.
std::optional<int> too_deep_at(std::string_view text);

}  // namespace phynness::scene_detail
