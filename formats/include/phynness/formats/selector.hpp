// How a scene chooses nodes of its mesh. Each selector is one struct in formats/src/selectors.cpp.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace phynness {

struct Mesh;

/// Where in a scene file a value stands, for messages: "file.toml:12".
struct SourceLocation {
  std::string file;
  int line = 0;
  std::string str() const { return file + ":" + std::to_string(line); }
};

using Vec3 = std::array<double, 3>;
using NodeList = std::vector<std::int32_t>;

/// What a selector needs to know of a body.
struct SelectableBody {
  /// No node is fixed yet. @pre the mesh has a node and outlives this
  explicit SelectableBody(const Mesh& mesh);

  const Mesh& mesh;
  NodeList surface;  ///< sorted
  NodeList fixed;    ///< sorted; set before anything is selected by what is free
  Vec3 low, high;    ///< bounding box [m]
  double slack_m;    ///< a node that lies on a border up to rounding is inside
};

/// What is asked of a selector.
struct PickRequest {
  const NodeList& candidates;  ///< sorted: all nodes, or those of the surface; others that are picked are dropped
  std::string nodes;           ///< "fixed nodes", "active nodes", "output nodes": for messages
  std::string place;           ///< "file.toml:12: " or empty: for messages
};

/// What a selector does, without the keys that all of them share.
class NodeChoice {
 public:
  virtual ~NodeChoice() = default;
  /// As it stands in the physics summary, and so in its hash: never changes.
  virtual std::string text() const = 0;
  /// For messages.
  virtual std::string description() const = 0;
  /// Nodes in any order.
  /// @throws Error (input) if the body does not have what is asked for
  virtual NodeList pick(const SelectableBody& body, const PickRequest& request) const = 0;
  /// Selects by what is not fixed, and so cannot select what is.
  virtual bool needs_fixed() const { return false; }
  /// Selects every node of any body: where all are fixed, none can move.
  virtual bool selects_all() const { return false; }
};

/// One selector; a selection is the union of a list of them.
struct Selector {
  std::shared_ptr<const NodeChoice> choice;
  bool surface_only = false;  ///< keep surface nodes only
  SourceLocation where;
};
using Selection = std::vector<Selector>;

/// A selection from the text that a scene has after `output =`; `where` of its selectors has no file.
/// @throws Error (input)
Selection parse_selection(const std::string& text);

/// Sorted list without repeats.
/// @param what   "fixed", "active", "output": for messages
/// @param where  of the selection, for messages
/// @throws Error (input) if a selector or all of them select nothing, or a selector asks for what the body
/// does not have
NodeList select_nodes(const Selection& selection, const SelectableBody& body, const char* what,
                      const SourceLocation& where);

}  // namespace phynness
