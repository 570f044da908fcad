// The keys a scene may hold: the one list that the parser, its messages and the test of scene.md share.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace phynness::scene_detail {

/// Keys of one table; "" is the top level, "selector.box" the table inside a box selector.
const std::vector<std::string_view>& keys_of(std::string_view table);

/// What to do about `key`, which `table` does not know: add the unit, change it, move it, or mend the
/// spelling.
std::string remedy_for_unknown_key(std::string_view table, std::string_view key);

/// The candidate that is nearest to `word` by edit distance; empty if none is near.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

/// "a, b or c"
std::string listed(const std::vector<std::string_view>& words, const char* last_joint = " or ");

}  // namespace phynness::scene_detail
