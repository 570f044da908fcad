// The selectors of a scene. Each is a function and a row of a table.
#pragma once

#include <functional>
#include <phynness/formats/printable.hpp>

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
  std::vector<std::string_view> keys;  ///< of its table; for SelectorForm::value further keys beside it
  /// @param table  the table of the selector; for SelectorForm::value the table that contains the selector
  /// @throws Error (input) with file and line
  std::function<NodeChoice(const SceneTable& table)> parse;
};

/// Selectors that are made of other selections.
std::vector<SelectorKind> selector_combinations();

/// All selectors, in the order of messages.
const std::vector<SelectorKind>& selector_kinds();

/// A selection that is the value of a key, or an item of its array. @param holder  the table of the key, for messages
Selection parse_selection(const toml::node& node, const SceneTable& holder, std::string_view key);

/// The text of a selection in the physics summary, which is hashed and must therefore never change.
std::string selection_text(const Selection& selection);
/// Its text in messages.
std::string selection_description(const Selection& selection);
/// The nodes of a selection, sorted and without repeats.
/// @throws Error (input) if one of its selectors selects no node
NodeList union_of(const Selection& selection, const SelectableBody& body, const PickRequest& request);

}  // namespace phynness::scene_detail
