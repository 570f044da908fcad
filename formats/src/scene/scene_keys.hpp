// The keys of a scene. Parser, messages, physics hash, `phynness info` and the tables of scene.md follow from them.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scene_table.hpp"

namespace phynness::scene_detail {

struct SceneKey {
  std::string_view section, name;
  std::string type, allowed, standard;  ///< in words; `standard` is empty if the key has no default
  std::string_view meaning;
  bool is_hashed;                                                   ///< whether it affects a solve
  std::function<void(const SceneTable& table, Scene& scene)> read;  ///< @pre the table has the key
  std::function<std::string(const Scene& scene)> text;              ///< of the value
};

/// All keys, section by section, in the order in which they are read and hashed.
const std::vector<SceneKey>& key_rows();

/// The keys of [mesh] with the dimensions of a shape.
std::vector<std::string_view> shape_keys(Shape shape);

/// Keys of a table; "" is the top level, "selector.box" is the table of a box selector.
const std::vector<std::string_view>& keys_of(std::string_view table);

/// The remedy for `key`, which is unknown in `table`: add or change the unit, move the key, or correct its spelling.
std::string remedy_for_unknown_key(std::string_view table, std::string_view key);

/// The candidate with the smallest edit distance from `word`; empty if none is similar.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& candidates);

/// "a, b or c"
std::string listed(const std::vector<std::string_view>& words, const char* last_joint = " or ");

}  // namespace phynness::scene_detail
