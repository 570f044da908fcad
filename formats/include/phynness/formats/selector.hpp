// Selection of mesh nodes by a scene. Each selector is a function in formats/src/scene/selectors.cpp or
// formats/src/scene/selector_combinations.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace phynness {

struct Mesh;

/// Position of a value in a scene file, for messages: "file.toml:12".
struct SourceLocation {
  std::string file;
  int line = 0;
  std::string str() const { return file + ":" + std::to_string(line); }
  /// "file.toml:12: " for the beginning of a message; empty without a file.
  std::string prefix() const { return file.empty() ? "" : str() + ": "; }
};

using Vec3 = std::array<double, 3>;
using NodeList = std::vector<std::int32_t>;

/// Properties of a body that selectors use.
struct SelectableBody {
  /// Initially no node is fixed. @pre the mesh has a node and outlives this object
  explicit SelectableBody(const Mesh& mesh);

  const Mesh& mesh;
  NodeList surface;          ///< sorted
  NodeList fixed;            ///< sorted; set before selectors that depend on it are applied
  NodeList probed;           ///< sorted: points that a database has, which spread points keep
  double tool_radius_m = 0;  ///< of the scene's probe; 0: it displaces a node
  Vec3 low, high;            ///< bounding box [m]
  double slack_m;            ///< a node up to this far outside of a border counts as inside, because of rounding
};

/// Arguments of a selection.
struct PickRequest {
  const NodeList& candidates;  ///< sorted: all nodes, or the surface nodes; other picked nodes are removed later
  std::string nodes;           ///< "fixed nodes", "active nodes" or "output nodes", for messages
  std::string place;           ///< "file.toml:12: " or empty, for messages
};

/// A selector without the keys that are common to all selectors.
struct NodeChoice {
  using Pick = std::function<NodeList(const SelectableBody& body, const PickRequest& request)>;

  std::string text = {};         ///< in the physics summary. It is hashed and must therefore never change
  std::string description = {};  ///< in messages
  /// The selected nodes in any order.
  /// @throws Error (input) if the body does not have the named group or node
  Pick pick = {};
  /// What to do if it selects no node of this body, for messages.
  std::function<std::string(const SelectableBody& body, const PickRequest& request)> remedy_if_empty =
      [](const SelectableBody&, const PickRequest&) { return "select by other nodes or places"; };
  bool needs_fixed = false;  ///< depends on the fixed nodes; if so, it cannot define them
  bool selects_all = false;  ///< selects every node of any body; if so, it cannot define the fixed nodes
  bool spreads = false;  ///< its nodes are spread over a part of the surface; a round tool is interpolated between them
  /// A sentence about a choice that is possible but probably not meant; empty: none. @param picked  by the selection
  std::function<std::string(const SelectableBody&, const NodeList& picked)> warning =
      [](const SelectableBody&, const NodeList&) { return ""; };
};

/// One selector; a selection is the union of a list of them.
struct Selector {
  std::shared_ptr<const NodeChoice> choice;
  bool surface_only = false;  ///< keep surface nodes only
  SourceLocation where;
};
using Selection = std::vector<Selector>;
/// Whether one of the selectors spreads its nodes.
bool spreads(const Selection& selection);
/// The default selection of active and output nodes.
Selection free_surface();

/// Parses a selection from the text after `output =` of a scene; `where` of its selectors has no file.
/// @throws Error (input)
Selection parse_selection(const std::string& text);

/// The selected nodes as a sorted list without repeats.
/// @param what   "fixed", "active" or "output", for messages
/// @param where  position of the selection, for messages
/// @throws Error (input) if a selector or the whole selection is empty, or if the body does not have a named group or
/// node
NodeList select_nodes(const Selection& selection, const SelectableBody& body, const char* what,
                      const SourceLocation& where);

}  // namespace phynness
