// The selectors of a scene. Each is a struct and a row of a table.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// The form of a selector in a scene.
enum class SelectorForm {
  word,   ///< "surface"
  value,  ///< { group = "lobe" }
  table,  ///< { sphere = { center_m = ..., radius_m = ... } }
};

/// A row of the table of selectors.
struct SelectorKind {
  std::string_view name;
  SelectorForm form;
  std::vector<std::string_view> keys;  ///< of its table, for SelectorForm::table
  /// @param table  the table of the selector; for SelectorForm::value the table that contains the selector
  /// @throws Error (input) with file and line
  std::shared_ptr<const NodeChoice> (*parse)(const SceneTable& table);
};

/// All selectors, in the order of messages.
const std::vector<SelectorKind>& selector_kinds();

/// The default selection of active and output nodes.
std::shared_ptr<const NodeChoice> free_surface();

}  // namespace phynness::scene_detail
