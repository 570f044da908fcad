// The sections of a body.txt in their order (formats/body.md): the only definition in code of its grammar. `io` is
// described in model_grammar.hpp; done(store) is called where later lines refer to a store.
#pragma once

#include <phynness/schema/grammar_lines.hpp>

namespace phynness::schema {

inline constexpr char body_first_line[] = "phynness-body 5\n";
inline constexpr int32_t largest_parameter_count = 8, most_body_modes = 1024;
/// Modes that n tools need. Of two tools at random places the largest forces of a body of 6, 9, 12, 18, 24 and 40 modes
/// are 3e9, 3e4, 35, 4.6, 4.7 and 4.3 N (demo, displacements up to 10 mm).
constexpr int32_t least_body_modes(int32_t n_tools) { return n_tools > 1 ? 9 * n_tools : 3 * n_tools; }
/// Springs act between tools of a body that are nearer than this part of their radius, or of a mean edge for tools that
/// are points (docs/theory.md, Near tools).
inline constexpr double near_part = 0.5;
/// Parts of a body with parameters of their own.
inline constexpr int32_t most_regions = 255;
/// Kinds of nodes of the surface (formats/body.md).
inline constexpr int32_t body_node_fixed = 0, body_node_moves = 1, body_node_touchable = 2, n_body_node_kinds = 3;

template <class IO, class Word>
void word_line(IO& io, const char* key, Word& word) {
  io.keyword(key);
  io.word(key, word);
  io.end();
}

/// Entries xx, xy, xz, yy, yz, zz of a symmetric matrix.
inline constexpr int32_t n_of_root = 6;

/// Of each region the parameters and the bulk of the shape, and of each cell 0 or the number of its region, from 1.
template <class IO, class Body>
void body_regions(IO& io, Body& b, int32_t n_parameters, int32_t n_points) {
  if (!io.optional("regions", io.rows(b.regions) > 0)) return;
  const int32_t n = size_line(io, "regions", io.rows(b.regions), 1, most_regions);
  io.shape("parameters of a region", b.regions, n, n_parameters + 1);
  for (int32_t r = 0; r < n && io.good(); ++r) {
    for (int32_t k = 0; k < n_parameters; ++k) number(io, "parameter", b.regions, r, k, any_number);
    number(io, "bulk", b.regions, r, n_parameters, not_negative);
    io.end();
  }
  rows_of_indices(io, "region of a cell", b.region_of_cell, n_points, n + 1);
}

inline constexpr char body_bounds_word[] = "bounds";

/// Coefficients of the bounds of errors, as many as those of coupled tools in a model.
template <class IO, class Body>
void body_bounds(IO& io, Body& b) {
  if (!io.optional(body_bounds_word, io.rows(b.bounds) > 0)) return;
  const int32_t kinds = size_line(io, body_bounds_word, io.rows(b.bounds), n_coupled_kinds, n_coupled_kinds);
  real_line(io, "coverage", b.coverage, probability);
  integer_line(io, "rays", b.n_rays, 1, largest_integer);
  rows_of_numbers(io, "coefficient", b.bounds, kinds, n_coupled_terms, exponent);
}

template <class IO, class Body>
void body(IO& io, Body& b) {
  word_line(io, "mesh", b.mesh_hash);
  word_line(io, "physics", b.physics_hash);
  word_line(io, "law", b.law);
  const int32_t n_parameters = size_line(io, "parameters", io.rows(b.parameters), 1, largest_parameter_count);
  row_line(io, "values", b.parameters, n_parameters, any_number);
  real_line(io, "bulk", b.bulk_in_shape_Pa, not_negative);
  real_line(io, "radius", b.tool_radius_m, not_negative);
  real_line(io, "depth", b.depth_m, body_depth);
  relaxation(io, b.relaxation);

  const int32_t n_nodes = count_line(io, "nodes", io.rows(b.nodes), 1);
  io.shape("nodes", b.nodes, n_nodes, 1);
  io.shape("kinds", b.kinds, n_nodes, 1);
  io.shape("points", b.points, n_nodes, 3);
  int32_t previous = -1;
  for (int32_t i = 0; i < n_nodes && io.good(); ++i) {
    require_ascending(io, integer(io, "node number", b.nodes, i, 0, 0, largest_integer), previous,
                      "node numbers must ascend");
    integer(io, "kind of a node", b.kinds, i, 0, 0, n_body_node_kinds - 1);
    for (int32_t k = 0; k < 3; ++k) number(io, "coordinate", b.points, i, k, coordinate);
    io.end();
  }
  const int32_t n_triangles = count_line(io, "surface", io.rows(b.surface), 1);
  io.shape("surface", b.surface, n_triangles, 3);
  for (int32_t t = 0; t < n_triangles && io.good(); ++t) {
    for (int32_t k = 0; k < 3; ++k) integer(io, "corner", b.surface, t, k, 0, n_nodes - 1);
    io.end();
  }

  const int32_t n_modes = size_line(io, "modes", io.cols(b.modes.entries), 1, most_body_modes);
  table(io, "displacements", b.modes, 3 * static_cast<int64_t>(n_nodes), n_modes);
  const int32_t n_points = count_line(io, "cells", io.rows(b.shear_m3), 1);
  io.shape("cells", b.shear_m3, n_points, 1);
  io.shape("cells", b.bulk_rJ, n_points, 1);
  for (int32_t c = 0; c < n_points && io.good(); ++c) {
    number(io, "volume", b.shear_m3, c, 0, not_negative);
    number(io, "weight of the change of volume", b.bulk_rJ, c, 0, not_negative);
    io.end();
  }
  body_regions(io, b, n_parameters, n_points);
  table(io, "gradients", b.gradients, 9 * static_cast<int64_t>(n_points), n_modes);
  if (io.optional("cells-at-rest", io.rows(b.cells_at_rest.entries) > 0)) {
    table(io, "cells-at-rest", b.cells_at_rest, n_modes, n_modes);
    table(io, "lack-at-rest", b.lack_at_rest, n_modes, n_modes);
  }
  const int32_t n_pressures = size_line(io, "pressures", io.cols(b.pressures.entries), 1, most_body_modes);
  table(io, "pressures-at-cells", b.pressures, n_points, n_pressures);
  if (io.optional("lacking-at-nodes", io.rows(b.lacking.entries) > 0))
    table(io, "lacking-at-nodes", b.lacking, n_nodes, n_of_root);
  body_bounds(io, b);
}

}  // namespace phynness::schema
