// The sections of a model.txt in their order, with counts and bounds: the one definition of the grammar that
// formats/model.md describes. It is a walk. `io` reads the text, writes it or counts its bytes, and knows how the numbers of
// a model are stored: in vectors (formats/src/model_text.cpp), in memory of the caller (runtime/src/load.cpp), or not at all
// (planning/src/model_size.cpp).
//
// What the walk asks of `io`:
//   keyword(word), end()                    a word as it stands; the end of a line
//   text(line), word(what, store)           the rest of a line and its end; a word of visible ASCII characters
//   real(what, value, bound)                a number; a reader sets the value, a writer puts it out
//   integer(what, value, low, high)
//   count(what, n, low)                     number of lines that follow, which the rest of the text must be able to hold
//   room(what, n)                           n numbers follow; the same
//   family(value)                           word of a family
//   optional(word, present)                 whether a section follows: a reader looks at its first word
//   require(condition, what)                refuses the model
//   good()                                  false after a refusal, where no exceptions say so
// and of stores, which are arrays with rows and columns, or of items:
//   shape(what, store, rows, cols)          a reader makes room, a writer checks that it agrees
//   rows(store), cols(store)                sizes as they are; a reader's are 0 before shape
//   get(store, i, k), set(store, i, k, v)   numbers; only writers get, only readers set
//   item(store, i), done(item)              parts with stores of their own; done when their last line was read
//   has_place(model, node)                  whether a node is an output or fixed node
#pragma once

#include <stdint.h>

#include <phynness/schema/bounds.hpp>
#include <phynness/schema/family.hpp>

namespace phynness::schema {

inline constexpr int32_t largest_integer = 0x7fffffff;

/// One number of a store.
template <class IO, class Store>
void number(IO& io, const char* what, Store& store, int64_t i, int64_t k, const Bound& bound) {
  double value = io.get(store, i, k);
  io.real(what, value, bound);
  if (io.good()) io.set(store, i, k, value);
}

/// One integer of a store. @return it
template <class IO, class Store>
int32_t integer(IO& io, const char* what, Store& store, int64_t i, int64_t k, int32_t low, int32_t high) {
  auto value = static_cast<int32_t>(io.get(store, i, k));
  io.integer(what, value, low, high);
  if (io.good()) io.set(store, i, k, value);
  return value;
}

/// A line of a keyword and one number.
template <class IO, class Value>
void real_line(IO& io, const char* key, Value& value, const Bound& bound) {
  io.keyword(key);
  io.real(key, value, bound);
  io.end();
}

/// A line of a keyword and a row of numbers.
template <class IO, class Store>
void row_line(IO& io, const char* key, Store& row, int64_t n, const Bound& bound) {
  io.keyword(key);
  io.shape(key, row, n, 1);
  for (int64_t k = 0; k < n; ++k) number(io, key, row, k, 0, bound);
  io.end();
}

/// A line of a keyword and one integer.
template <class IO, class Value>
void integer_line(IO& io, const char* key, Value& value, int32_t low, int32_t high) {
  io.keyword(key);
  io.integer(key, value, low, high);
  io.end();
}

/// The same of a size, which a writer finds. @return it
template <class IO>
int32_t size_line(IO& io, const char* key, int64_t size, int32_t low, int32_t high) {
  auto n = static_cast<int32_t>(size);
  integer_line(io, key, n, low, high);
  return n;
}

/// A line of a keyword and the number of lines that follow. @return that
template <class IO>
int32_t count_line(IO& io, const char* key, int64_t rows, int32_t low = 0) {
  auto n = static_cast<int32_t>(rows);
  io.keyword(key);
  io.count(key, n, low);
  io.end();
  return n;
}

/// n lines of a row of numbers each.
template <class IO, class Store>
void rows_of_numbers(IO& io, const char* what, Store& store, int64_t n, int32_t n_columns, const Bound& bound) {
  io.shape(what, store, n, n_columns);
  for (int64_t i = 0; i < n && io.good(); ++i) {
    for (int32_t k = 0; k < n_columns; ++k) number(io, what, store, i, k, bound);
    io.end();
  }
}

/// n lines of one integer each, below `end`.
template <class IO, class Store>
void rows_of_indices(IO& io, const char* what, Store& store, int32_t n, int64_t end) {
  io.shape(what, store, n, 1);
  for (int32_t i = 0; i < n && io.good(); ++i) {
    integer(io, what, store, i, 0, 0, static_cast<int32_t>(end - 1));
    io.end();
  }
}

template <class IO>
void require_ascending(IO& io, int32_t value, int32_t& previous, const char* what) {
  io.require(value > previous, what);
  previous = value;
}

/// K_xx K_xy K_xz K_yy K_yz K_zz.
template <class IO, class Store>
void stiffness_line(IO& io, Store& stiffness) {
  io.keyword("stiffness");
  for (int32_t i = 0; i < 3; ++i) {
    for (int32_t j = i; j < 3; ++j) number(io, "stiffness", stiffness, i, j, linear_entry);
  }
  io.end();
}

/// TABLE of formats/model.md.
template <class IO, class Table>
void table(IO& io, const char* key, Table& table, int64_t n_rows, int32_t n_columns) {
  io.keyword(key);
  io.shape(key, table.scale, n_columns, 1);
  for (int32_t c = 0; c < n_columns; ++c) number(io, "scale", table.scale, c, 0, table_scale);
  io.end();
  io.room(key, static_cast<uint64_t>(n_rows) * static_cast<uint64_t>(n_columns));
  io.shape(key, table.entries, n_rows, n_columns);
  for (int64_t r = 0; r < n_rows && n_columns > 0 && io.good(); ++r) {
    for (int32_t c = 0; c < n_columns; ++c)
      integer(io, "table entry", table.entries, r, c, -largest_table_entry, largest_table_entry);
    io.end();
  }
}

/// Rows of `displacements` on which kernels are centered.
template <class IO, class Model, class Store>
void amplitude_centers(IO& io, Model& model, Store& centers, int32_t n) {
  rows_of_indices(io, "displacement of a center", centers, n, io.rows(model.displacements));
}

/// The networks of Gaussians of the paper, (11)-(12).
struct RbfnGrammar {
  static constexpr Family family = Family::rbfn;

  /// @param n_inputs  3: the displacement; 6: that and coordinates of an output node
  template <class IO, class Model, class Network>
  static void network(IO& io, Model& model, Network& net, const char* key, int32_t n_inputs) {
    const int32_t n = count_line(io, key, io.rows(net.weights));
    row_line(io, "input_center", net.input_center, n_inputs, any_number);
    row_line(io, "input_half_range", net.input_half_range, n_inputs, positive);
    row_line(io, "output_center", net.output_center, 3, any_number);
    row_line(io, "output_half_range", net.output_half_range, 3, positive);
    real_line(io, "spread", net.spread, width);
    row_line(io, "bias", net.bias, 3, any_number);
    const bool deforms = n_inputs == 6;
    io.shape("displacement of a center", net.center_displacement, n, 1);
    io.shape("output node of a center", net.center_output, deforms ? n : 0, 1);
    io.shape("weight", net.weights, n, 3);
    const auto n_displacements = static_cast<int32_t>(io.rows(model.displacements));
    const auto n_output = static_cast<int32_t>(io.rows(model.output));
    for (int32_t i = 0; i < n && io.good(); ++i) {
      integer(io, "displacement of a center", net.center_displacement, i, 0, 0, n_displacements - 1);
      if (deforms) integer(io, "output node of a center", net.center_output, i, 0, 0, n_output - 1);
      for (int32_t k = 0; k < 3; ++k) number(io, "weight", net.weights, i, k, any_number);
      io.end();
    }
    io.done(net);
  }

  template <class IO, class Network, class First>
  static void first_neurons(IO& io, const char* key, Network& full, First& first) {
    const int32_t n = count_line(io, key, io.rows(first.weights));
    io.require(n <= io.rows(full.weights), "a level has more neurons than its model");
    row_line(io, "bias", first.bias, 3, any_number);
    rows_of_numbers(io, "weight", first.weights, n, 3, any_number);
    io.done(first);
  }

  template <class IO, class Model>
  static void shared(IO&, Model&) {}
  template <class IO, class Model, class Level>
  static void level(IO&, Model&, Level&) {}
  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    network(io, model, node.force, "force", 3);
    network(io, model, node.deformation, "deformation", 6);
  }
  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO& io, Model&, Node& node, Level&, NodeLevel& level) {
    first_neurons(io, "force", node.force, level.force);
    first_neurons(io, "deformation", node.deformation, level.deformation);
  }
};

/// Unit responses of a linear body.
struct LinearGrammar {
  static constexpr Family family = Family::linear;

  template <class IO, class Model>
  static void shared(IO&, Model&) {}
  template <class IO, class Model, class Level>
  static void level(IO&, Model&, Level&) {}
  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    stiffness_line(io, node.linear.stiffness);
    io.keyword("unit_responses");
    io.end();
    rows_of_numbers(io, "unit response", node.linear.unit_responses, io.rows(model.output), 9, linear_entry);
    io.done(node.linear);
  }
  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO&, Model&, Node&, Level&, NodeLevel&) {}
};

/// Conservative forces, modes of the deformation, scalar fields.
struct ModalGrammar {
  static constexpr Family family = Family::modal;

  template <class IO, class Model>
  static void fields(IO& io, Model& model) {
    if (!io.optional("fields", io.rows(model.fields) > 0)) return;
    const int32_t n = size_line(io, "fields", io.rows(model.fields), 1, largest_field_count);
    io.shape("fields", model.fields, n, 1);
    for (int32_t f = 0; f < n && io.good(); ++f) {
      auto& field = io.item(model.fields, f);
      io.keyword("field");
      io.word("name of a field", field.name);
      io.word("unit of a field", field.unit);
      io.end();
      integer_line(io, "degree", field.degree, 1, 2);
      real_line(io, "scale", field.scale, field_scale);
      const int32_t n_modes = size_line(io, "shared_modes", io.cols(field.modes.entries), 0, largest_mode_count);
      table(io, "modes", field.modes, io.rows(model.output), n_modes);
      io.done(field);
    }
  }

  template <class IO, class Model>
  static void shared(IO& io, Model& model) {
    auto& modes = model.shared.modes;
    const int32_t n_modes = size_line(io, "shared_modes", io.cols(modes.entries), 0, largest_mode_count);
    table(io, "modes", modes, 3 * io.rows(model.output), n_modes);
    const int32_t n = count_line(io, "amplitude_centers", io.rows(model.shared.centers));
    real_line(io, "shape", model.shared.shape, width);
    amplitude_centers(io, model, model.shared.centers, n);
    io.done(model.shared);
    fields(io, model);
  }

  template <class IO, class Model, class Level>
  static void level(IO& io, Model& model, Level& level) {
    const int32_t n = count_line(io, "amplitude_centers", io.rows(level.centers));
    io.require(n <= io.rows(model.shared.centers), "a level has more centers than its model");
    if (io.good()) amplitude_centers(io, model, level.centers, n);
  }

  template <class IO, class Model, class Force>
  static void force(IO& io, Model& model, Force& force) {
    const int32_t n = count_line(io, "force", io.rows(force.centers));
    real_line(io, "shape", force.shape, width);
    stiffness_line(io, force.stiffness);
    io.shape("displacement of a center", force.centers, n, 1);
    io.shape("coefficient", force.coefficients, n, 3);
    const auto n_displacements = static_cast<int32_t>(io.rows(model.displacements));
    for (int32_t i = 0; i < n && io.good(); ++i) {
      integer(io, "displacement of a center", force.centers, i, 0, 0, n_displacements - 1);
      for (int32_t k = 0; k < 3; ++k) number(io, "coefficient", force.coefficients, i, k, linear_entry);
      io.end();
    }
    io.done(force);
  }

  /// @param components  rows of an output node: 3, of a field 1
  template <class IO, class Model, class Modes>
  static void modes(IO& io, Model& model, const char* key, Modes& modes, int64_t n_basis, int64_t n_shared,
                    int32_t components) {
    const int32_t m = size_line(io, key, io.cols(modes.weights.entries), 0, largest_mode_count);
    table(io, "weights", modes.weights, n_basis, m);
    table(io, "mixing", modes.mixing, n_shared, m);
    const int32_t n_near = count_line(io, "near", io.rows(modes.near));
    io.shape("near node", modes.near, n_near, 1);
    int32_t previous = -1;
    for (int32_t i = 0; i < n_near && io.good(); ++i) {
      const auto n_output = static_cast<int32_t>(io.rows(model.output));
      const int32_t position = integer(io, "near node", modes.near, i, 0, 0, n_output - 1);
      require_ascending(io, position, previous, "near nodes must ascend");
      io.end();
    }
    table(io, "near_modes", modes.near_modes, static_cast<int64_t>(components) * n_near, m);
  }

  template <class IO, class Model, class Node>
  static void response(IO& io, Model& model, Node& node) {
    const int64_t n_centers = io.rows(model.shared.centers), n_fields = io.rows(model.fields);
    force(io, model, node.conservative);
    modes(io, model, "deformation", node.modal, n_centers + n_linear_terms, io.cols(model.shared.modes.entries), 3);
    io.shape("fields", node.fields, n_fields, 1);
    for (int64_t f = 0; f < n_fields && io.good(); ++f)
      modes(io, model, "field", io.item(node.fields, f), n_centers + n_field_terms,
            io.cols(io.item(model.fields, f).modes.entries), 1);
  }

  /// Number of modes and weights of the amplitudes: a node has modes at every level or at none.
  template <class IO, class Full, class Weights>
  static void level_weights(IO& io, const char* key, Full& full, Weights& weights, int64_t n_basis) {
    const auto n_full = static_cast<int32_t>(io.cols(full.weights.entries));
    io.keyword(key);
    auto n = static_cast<int32_t>(io.cols(weights.entries));
    io.integer("modes of a level", n, n_full > 0 ? 1 : 0, n_full);
    io.end();
    table(io, "weights", weights, n_basis, n);
  }

  template <class IO, class Model, class Node, class Level, class NodeLevel>
  static void level_response(IO& io, Model& model, Node& node, Level& level, NodeLevel& of_node) {
    force(io, model, of_node.conservative);
    io.require(io.rows(of_node.conservative.centers) <= io.rows(node.conservative.centers),
               "a level has more force centers than its model");
    const int64_t n_centers = io.rows(level.centers), n_fields = io.rows(model.fields);
    level_weights(io, "deformation", node.modal, of_node.weights, n_centers + n_linear_terms);
    io.shape("fields", of_node.field_weights, n_fields, 1);
    for (int64_t f = 0; f < n_fields && io.good(); ++f)
      level_weights(io, "field", io.item(node.fields, f), io.item(of_node.field_weights, f),
                    n_centers + n_field_terms);
  }
};

/// Calls f with the grammar of a family.
template <class Function>
void with_grammar(Family family, Function&& f) {
  if (family == RbfnGrammar::family) f(RbfnGrammar{});
  if (family == LinearGrammar::family) f(LinearGrammar{});
  if (family == ModalGrammar::family) f(ModalGrammar{});
}

template <class IO, class Store, class Points>
void nodes_and_points(IO& io, const char* key, int32_t n_mesh_nodes, Store& nodes, Points& points) {
  const int32_t n = count_line(io, key, io.rows(nodes));
  io.shape(key, nodes, n, 1);
  io.shape(key, points, n, 3);
  int32_t previous = -1;
  for (int32_t i = 0; i < n && io.good(); ++i) {
    const int32_t node = integer(io, "node number", nodes, i, 0, 0, n_mesh_nodes - 1);
    require_ascending(io, node, previous, "node numbers must ascend");
    for (int32_t k = 0; k < 3; ++k) number(io, "coordinate", points, i, k, coordinate);
    io.end();
  }
  io.done(nodes);
}

template <class IO, class Model>
void surface(IO& io, Model& model) {
  const int32_t n = count_line(io, "surface", io.rows(model.surface));
  io.shape("surface", model.surface, n, 3);
  for (int32_t t = 0; t < n && io.good(); ++t) {
    for (int32_t k = 0; k < 3; ++k) {
      const int32_t node = integer(io, "corner", model.surface, t, k, 0, model.n_mesh_nodes - 1);
      io.require(io.has_place(model, node), "a corner of the surface is neither output nor fixed");
    }
    io.end();
  }
}

template <class Grammar, class IO, class Model>
void levels(IO& io, Model& model) {
  if (!traits(Grammar::family).has_levels || !io.optional("levels", io.rows(model.levels) > 0)) return;
  const int32_t n = size_line(io, "levels", io.rows(model.levels), 2, largest_level_count);
  io.shape("levels", model.levels, n, 1);
  for (int32_t l = 0; l < n && io.good(); ++l) {
    auto& level = io.item(model.levels, l);
    io.keyword("level");
    io.real("error of a level", level.error_force, level_error);
    io.real("error of a level", level.error_displacement, level_error);
    io.end();
    if (l + 1 < n) Grammar::level(io, model, level);
    io.done(level);
  }
}

template <class Grammar, class IO, class Model, class Node>
void active_node(IO& io, Model& model, Node& node, int32_t& previous) {
  io.keyword("node");
  io.integer("node number", node.node, 0, model.n_mesh_nodes - 1);
  require_ascending(io, node.node, previous, "node numbers must ascend");
  io.end();
  io.keyword("point");
  for (int32_t k = 0; k < 3; ++k) number(io, "point", node.point, k, 0, coordinate);
  io.end();
  const int32_t n_prescribed = count_line(io, "prescribed", io.rows(node.prescribed), 1);
  io.shape("prescribed", node.prescribed, n_prescribed, 1);
  io.shape("prescribed", node.prescribed_weight, n_prescribed, 1);
  int32_t previous_prescribed = -1;
  for (int32_t i = 0; i < n_prescribed && io.good(); ++i) {
    const int32_t moved = integer(io, "node number", node.prescribed, i, 0, 0, model.n_mesh_nodes - 1);
    require_ascending(io, moved, previous_prescribed, "node numbers must ascend");
    number(io, "weight of a prescribed node", node.prescribed_weight, i, 0, probe_weight);
    io.end();
  }
  const auto n_directions = static_cast<int32_t>(io.rows(model.directions));
  integer_line(io, "incomplete", node.n_incomplete, 0, n_directions);
  io.keyword("trained_depth");
  io.end();
  rows_of_numbers(io, "trained depth", node.trained_depth_m, n_directions, 1, not_negative);
  Grammar::response(io, model, node);
  const int64_t n_smaller = io.rows(model.levels) > 0 ? io.rows(model.levels) - 1 : 0;
  io.shape("levels", node.levels, n_smaller, 1);
  for (int64_t l = 0; l < n_smaller && io.good(); ++l) {
    auto& level = io.item(node.levels, l);
    Grammar::level_response(io, model, node, io.item(model.levels, l), level);
    io.done(level);
  }
  io.done(node);
}

/// Everything between the first line and the checksum.
template <class IO, class Model>
void model(IO& io, Model& model) {
  io.keyword("family");
  io.family(model.family);
  io.end();
  io.keyword("title");
  io.text(model.title);
  io.keyword("software");
  io.text(model.software_version);
  io.keyword("mesh_hash");
  io.text(model.mesh_hash);
  io.keyword("physics_hash");
  io.text(model.physics_hash);
  real_line(io, "max_displacement_m", model.max_displacement_m, positive);
  integer_line(io, "mesh_nodes", model.n_mesh_nodes, 1, largest_integer);
  const int32_t n_directions = count_line(io, "directions", io.rows(model.directions), 1);
  rows_of_numbers(io, "direction", model.directions, n_directions, 3, any_number);
  const int32_t n_displacements = count_line(io, "displacements", io.rows(model.displacements), 1);
  io.require(io.good() && n_displacements % n_directions == 0, "displacements must be a multiple of directions");
  rows_of_numbers(io, "displacement", model.displacements, n_displacements, 3, any_number);
  io.done(model.displacements);
  nodes_and_points(io, "fixed", model.n_mesh_nodes, model.fixed, model.fixed_points);
  nodes_and_points(io, "output", model.n_mesh_nodes, model.output, model.output_points);
  surface(io, model);
  if (!io.good()) return;
  with_grammar(model.family, [&](auto grammar) {
    using Grammar = decltype(grammar);
    Grammar::shared(io, model);
    levels<Grammar>(io, model);
    const int32_t n_active = count_line(io, "active", io.rows(model.nodes));
    io.shape("active", model.nodes, n_active, 1);
    int32_t previous = -1;
    for (int32_t i = 0; i < n_active && io.good(); ++i)
      active_node<Grammar>(io, model, io.item(model.nodes, i), previous);
  });
}

}  // namespace phynness::schema
