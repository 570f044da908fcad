// The selectors of a scene, each one struct and one row of a table.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// How a scene writes a selector.
enum class SelectorForm {
  word,   ///< "surface"
  value,  ///< { group = "lobe" }
  table,  ///< { sphere = { center_m = ..., radius_m = ... } }
};

/// One row.
struct SelectorKind {
  std::string_view name;
  SelectorForm form;
  std::vector<std::string_view> keys;  ///< of its table, for SelectorForm::table
  /// @param table  of the selector's own keys; for SelectorForm::value the one that holds the selector
  /// @throws Error (input) with file and line
  std::shared_ptr<const NodeChoice> (*parse)(const SceneTable& table);
};

/// Every selector, in the order in which messages list them.
const std::vector<SelectorKind>& selector_kinds();

/// What a scene means that does not select active or output nodes.
std::shared_ptr<const NodeChoice> free_surface();

}  // namespace phynness::scene_detail
