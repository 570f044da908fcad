// Selection of mesh nodes by a scene. Each selector is a struct in formats/src/selectors.cpp or
// formats/src/selector_combinations.cpp.
#pragma once

#include <array>
#include <cstdint>
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
  NodeList image;            ///< as MirrorSymmetry::image; empty: the scene declares no symmetry
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
class NodeChoice {
 public:
  virtual ~NodeChoice() = default;
  /// Text in the physics summary. It is hashed and must therefore never change.
  virtual std::string text() const = 0;
  /// Text in messages.
  virtual std::string description() const = 0;
  /// The selected nodes in any order.
  /// @throws Error (input) if the body does not have the named group or node
  virtual NodeList pick(const SelectableBody& body, const PickRequest& request) const = 0;
  /// The nodes from which it spreads its points over a part of the surface; of other selectors pick().
  virtual NodeList candidates(const SelectableBody& body, const PickRequest& request) const {
    return pick(body, request);
  }
  /// What to do if it selects no node of this body, for messages.
  virtual std::string remedy_if_empty(const SelectableBody& body, const PickRequest& request) const;
  /// Whether the selection depends on the fixed nodes; if so, it cannot define them.
  virtual bool needs_fixed() const { return false; }
  /// Whether it selects every node of any body; if so, it cannot define the fixed nodes.
  virtual bool selects_all() const { return false; }
  /// Whether it selects nodes that are spread over a part of the surface, between which a round tool is interpolated.
  virtual bool spreads() const { return false; }
  /// A sentence about a choice that is possible but probably not meant; empty: none. @param picked  by the selection
  virtual std::string warning(const SelectableBody&, const NodeList& picked) const;
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
