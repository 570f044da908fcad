// The sections of a model.txt in their order, with counts and bounds: the only definition in code of the grammar that
// formats/model.md describes. The functions visit the sections of a model in order and call `io` for each part. `io`
// reads the text or writes it. It also knows how the numbers of a model are stored: in vectors
// (formats/src/model/model_text.cpp) or in memory of the caller (runtime/src/core/load.cpp).
//
// Members of `io` for the text:
//   keyword(word), end()                    a fixed word; the end of a line
//   text(line), word(what, store)           the rest of a line and its end; a word of visible ASCII characters
//   real(what, value, bound)                a number; a reader sets the value, a writer writes it
//   integer(what, value, low, high)         an integer
//   family(value)                           the word of a family
//   count(what, n, low)                     number of lines that follow; a reader refuses more than the text can hold
//   room(what, n)                           n numbers follow; a reader refuses more than the text can hold
//   optional(word, present)                 whether a section follows; a reader looks at its first word
//   require(condition, what)                refuses the model if the condition is false
//   good()                                  false after an error, for readers without exceptions
// Members of `io` for stores, which are arrays of numbers with rows and columns, or arrays of items:
//   shape(what, store, rows, cols)          a reader allocates the store, a writer checks its size
//   rows(store), cols(store)                present size; 0 for a reader before shape
//   get(store, i, k), set(store, i, k, v)   numbers; only writers call get, only readers call set
//   item(store, i), done(item)              an item with stores of its own; done is called after its last line
//   has_place(model, node)                  whether a node is an output or fixed node
//   has_output(model, node)                 whether a node is an output node
#pragma once

#include <phynness/schema/linear/grammar.hpp>
#include <phynness/schema/modal/grammar.hpp>
#include <phynness/schema/rbfn/grammar.hpp>

namespace phynness::schema {

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

template <class IO, class Level>
void level_line(IO& io, Level& level) {
  io.keyword("level");
  io.real("error of a level", level.error_force, level_error);
  io.real("error of a level", level.error_displacement, level_error);
  io.end();
}

template <class Grammar, class IO, class Model>
void levels(IO& io, Model& model) {
  if (!traits(Grammar::family).has_levels || !io.optional("levels", io.rows(model.levels) > 0)) return;
  const int32_t n = size_line(io, "levels", io.rows(model.levels), 2, largest_level_count);
  io.shape("levels", model.levels, n, 1);
  for (int32_t l = 0; l < n && io.good(); ++l) {
    auto& level = io.item(model.levels, l);
    level_line(io, level);
    if (l + 1 < n) Grammar::level(io, model, level);
    io.done(level);
  }
}

/// Bounds of errors. A family that is exact needs none.
template <class IO, class Model>
void bounds(IO& io, Model& model) {
  if (traits(model.family).proportional || !io.optional("bounds", io.rows(model.bounds) > 0)) return;
  const int32_t n = size_line(io, "bounds", io.rows(model.bounds), 1, largest_bound_count);
  io.shape("bounds", model.bounds, n, 1);
  for (int32_t b = 0; b < n && io.good(); ++b) {
    auto& bound = io.item(model.bounds, b);
    real_line(io, "coverage", bound.coverage, probability);
    integer_line(io, "rays", bound.n_rays, 1, largest_integer);
    integer_line(io, "nodes", bound.n_nodes, 1, largest_integer);
    integer_line(io, "reference", bound.reference, 0, n_bound_references);
    row_line(io, "between", bound.between, n_coupled_terms, exponent);
  }
}

/// Stores a flag that a reader has read; a writer's is constant.
inline void store_flag(bool& to, bool value) { to = value; }
inline void store_flag(const bool&, bool) {}

/// The equations that the finite elements solved.
template <class IO, class Solved>
void solved(IO& io, Solved& body) {
  const bool recorded = io.optional("solved", body.is_recorded);
  store_flag(body.is_recorded, recorded);
  if (!recorded) return;
  io.keyword("solved");
  io.word("element", body.element);
  io.real("shear modulus", body.shear_modulus_Pa, positive);
  io.end();
}

inline constexpr int32_t n_distance_parts = 6;
/// Distance of the finite elements from a finer solution.
template <class IO, class Distance>
void finer(IO& io, Distance& distance) {
  const bool measured = io.optional("finer", distance.is_measured);
  store_flag(distance.is_measured, measured);
  if (!measured) return;
  io.keyword("finer");
  io.word("element", distance.element);
  io.word("reference", distance.reference);
  io.integer("probes", distance.probes, 0, largest_integer);
  io.real("tool_radius_m", distance.tool_radius_m, not_negative);
  io.real("mean", distance.mean, not_negative);
  io.real("p95", distance.p95, not_negative);
  io.integer("nodes", distance.nodes, 1, largest_integer);
  io.integer("solved probes", distance.solved, 0, largest_integer);
  io.end();
  const bool with_parts = io.optional("parts", distance.has_parts);
  store_flag(distance.has_parts, with_parts);
  if (!with_parts) return;
  real_line(io, "parts", distance.unknowns_factor, not_negative);
  for (int32_t i = 0; i < n_distance_parts; ++i) {
    auto& part = distance.part(i);
    io.integer("places", part.places, 0, largest_integer);
    io.real("mean", part.mean, not_negative);
    io.real("p95", part.p95, not_negative);
    io.end();
  }
  if (io.optional("force_ratio", distance.force_ratio > 0))
    real_line(io, "force_ratio", distance.force_ratio, positive);
}

template <class IO, class Model, class Node>
void node_line(IO& io, Model& model, Node& node, int32_t& previous) {
  io.keyword("node");
  io.integer("node number", node.node, 0, model.n_mesh_nodes - 1);
  require_ascending(io, node.node, previous, "node numbers must ascend");
  io.end();
  io.keyword("point");
  for (int32_t k = 0; k < 3; ++k) number(io, "point", node.point, k, 0, coordinate);
  io.end();
}

/// The first lines of an active node, the same for every family. A round tool moves the weighted mean of its nodes by
/// d; otherwise each node is displaced by its weight times d, a single one by d.
template <class IO, class Model, class Node>
void node_lines(IO& io, Model& model, Node& node, int32_t& previous) {
  node_line(io, model, node, previous);
  const bool mean = io.optional("mean", node.moves_mean);
  if (mean) {
    io.keyword("mean");
    io.end();
  }
  store_flag(node.moves_mean, mean);
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
}

template <class Grammar, class IO, class Model, class Node>
void active_node(IO& io, Model& model, Node& node, int32_t& previous) {
  node_lines(io, model, node, previous);
  Grammar::response(io, model, node);
  const int64_t n_smaller = io.rows(model.levels) > 0 ? io.rows(model.levels) - 1 : 0;
  io.shape("levels", node.levels, n_smaller, 1);
  for (int64_t l = 0; l < n_smaller && io.good(); ++l) {
    auto& level = io.item(node.levels, l);
    Grammar::level_response(io, model, node, io.item(model.levels, l), level);
    io.done(level);
  }
  const int64_t n_bounds = io.rows(model.bounds);
  io.shape("bounds", node.bounds, n_bounds, 1);
  for (int64_t b = 0; b < n_bounds && io.good(); ++b)
    table(io, "bound", io.item(node.bounds, b), io.rows(model.displacements), 1);
  io.done(node);
}

/// Points of the surface that were not probed, whose response is that at rest.
template <class IO, class Model>
void linear_points(IO& io, Model& model) {
  if (!io.optional("linear_points", io.rows(model.linear_points) > 0)) return;
  const int32_t n = count_line(io, "linear_points", io.rows(model.linear_points), 1);
  const int32_t n_modes = size_line(io, "rest_modes", io.cols(model.rest_modes.entries), 0, largest_mode_count);
  table(io, "modes", model.rest_modes, 3 * io.rows(model.output), n_modes);
  io.shape("linear_points", model.linear_points, n, 1);
  int32_t previous = -1;
  for (int32_t i = 0; i < n && io.good(); ++i) {
    auto& point = io.item(model.linear_points, i);
    node_line(io, model, point, previous);
    stiffness_line(io, point.stiffness);
    mixed_modes(io, model, point, n_modes, 3, 3);
    io.done(point);
  }
}

template <class IO, class Store>
void triangles(IO& io, const char* key, Store& store, int32_t n_points) {
  const int32_t n = count_line(io, key, io.rows(store));
  io.shape(key, store, n, 3);
  for (int32_t t = 0; t < n && io.good(); ++t) {
    for (int32_t k = 0; k < 3; ++k) integer(io, "corner", store, t, k, 0, n_points - 1);
    io.end();
  }
}

/// Coordinates of surface nodes between points: triangles of active nodes, those that also have linear points, whose
/// positions follow, and for each covered node its triangle, the weight of its first corner, and the part of the rest
/// that the second has, in parts of `whole_weight`.
template <class IO, class Model>
void coordinates(IO& io, Model& model, int32_t n_active) {
  if (!io.optional("triangles", io.rows(model.covered) > 0)) return;
  const auto n_linear = static_cast<int32_t>(io.rows(model.linear_points));
  triangles(io, "triangles", model.probe_triangles, n_active);
  if (n_linear > 0) triangles(io, "outer_triangles", model.outer_triangles, n_active + n_linear);
  const auto n_triangles = static_cast<int32_t>(io.rows(model.probe_triangles) + io.rows(model.outer_triangles));
  const int32_t n = count_line(io, "covered", io.rows(model.covered), 1);
  io.shape("covered", model.covered, n, 4);
  int32_t previous = -1;
  for (int32_t i = 0; i < n && io.good(); ++i) {
    const int32_t node = integer(io, "node number", model.covered, i, 0, 0, model.n_mesh_nodes - 1);
    require_ascending(io, node, previous, "node numbers must ascend");
    io.require(io.has_output(model, node), "a covered node is not an output node");
    integer(io, "triangle", model.covered, i, 1, 0, n_triangles - 1);
    for (int32_t k = 2; k < 4; ++k) integer(io, "weight", model.covered, i, k, 0, whole_weight);
    io.end();
  }
}

/// All lines between the first line and the checksum.
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
    bounds(io, model);
    solved(io, model.solved);
    relaxation(io, model.relaxation);
    finer(io, model.finer);
    linear_points(io, model);
    const int32_t n_active = count_line(io, "active", io.rows(model.nodes));
    io.shape("active", model.nodes, n_active, 1);
    int32_t previous = -1;
    for (int32_t i = 0; i < n_active && io.good(); ++i)
      active_node<Grammar>(io, model, io.item(model.nodes, i), previous);
    if (io.good()) coordinates(io, model, n_active);
  });
}

}  // namespace phynness::schema
