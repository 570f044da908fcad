// The selectors of a scene. Each is a function and a row of a table.
#pragma once

#include "scene_table.hpp"

namespace phynness::scene_detail {

/// The form of a selector in a scene.
enum class SelectorForm {
  word,   ///< "surface"
  value,  ///< { group = "lobe" }
  table,  ///< { sphere = { center_m = ..., radius_m = ... } }
};

struct SelectorRow {
  std::string_view name;
  SelectorKind kind;
  SelectorForm form;
  std::vector<std::string_view> keys = {};  ///< of its table
  /// Reads numbers and texts; null for words, which have none.
  /// @param table  the table of the selector; for SelectorForm::value the table that contains the selector
  /// @throws Error (input) with file and line
  void (*read)(const SceneTable& table, std::string_view name, Selector& selector) = nullptr;
};
/// Further keys of spread points, which stand beside spacing_m, spacing or count.
inline constexpr std::string_view keys_beside_values[] = {"within", "from_fixed_m"};
/// All selectors, in the order of messages.
const std::vector<SelectorRow>& selector_rows();

/// A selection that is the value of a key, or an item of its array. @param holder  the table of the key, for messages
Selection parse_selection(const toml::node& node, const SceneTable& holder, std::string_view key);

/// The text of a selection in the physics summary.
std::string selection_text(const Selection& selection);

}  // namespace phynness::scene_detail
