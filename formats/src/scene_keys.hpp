// The keys of a scene. The parser, its messages and the test of scene.md use this list.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace phynness::scene_detail {

/// Keys of a table; "" is the top level, "selector.box" is the table of a box selector.
const std::vector<std::string_view>& keys_of(std::string_view table);

/// The remedy for `key`, which is unknown in `table`: add or change the unit, move the key, or correct its spelling.
std::string remedy_for_unknown_key(std::string_view table, std::string_view key);

/// The candidate with the smallest edit distance from `word`; empty if none is similar.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

/// "a, b or c"
std::string listed(const std::vector<std::string_view>& words, const char* last_joint = " or ");

}  // namespace phynness::scene_detail
