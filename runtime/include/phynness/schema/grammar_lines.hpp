// Lines of a model.txt, used by its grammar. `io` and stores are described in model_grammar.hpp.
#pragma once

#include <stdint.h>

#include <phynness/schema/bounds.hpp>
#include <phynness/schema/family.hpp>

namespace phynness::schema {

inline constexpr int32_t largest_integer = 0x7fffffff;

/// Reads or writes one number of a store.
template <class IO, class Store>
void number(IO& io, const char* what, Store& store, int64_t i, int64_t k, const Bound& bound) {
  double value = io.get(store, i, k);
  io.real(what, value, bound);
  if (io.good()) io.set(store, i, k, value);
}

/// Reads or writes one integer of a store. @return the integer
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

/// A line of a keyword and a size. @param size  known when writing. @return the size read or written
template <class IO>
int32_t size_line(IO& io, const char* key, int64_t size, int32_t low, int32_t high) {
  auto n = static_cast<int32_t>(size);
  integer_line(io, key, n, low, high);
  return n;
}

/// A line of a keyword and the number of lines that follow. @return that number
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

/// The line "stiffness K_xx K_xy K_xz K_yy K_yz K_zz".
template <class IO, class Store>
void stiffness_line(IO& io, Store& stiffness) {
  io.keyword("stiffness");
  for (int32_t i = 0; i < 3; ++i)
    for (int32_t j = i; j < 3; ++j) number(io, "stiffness", stiffness, i, j, linear_entry);
  io.end();
}

/// The Prony series of a body that relaxes: rows of g and tau [s].
template <class IO, class Relaxation>
void relaxation(IO& io, Relaxation& relaxation) {
  if (!io.optional("relaxation", io.rows(relaxation.terms) > 0)) return;
  const int32_t n = size_line(io, "relaxation", io.rows(relaxation.terms), 1, largest_relaxation_count);
  real_line(io, "length", relaxation.length_m, not_negative);
  io.shape("term", relaxation.terms, n, 2);
  double sum = 0;
  for (int32_t i = 0; i < n && io.good(); ++i) {
    double g = io.get(relaxation.terms, i, 0);
    io.real("g", g, relaxing_share);
    if (io.good()) io.set(relaxation.terms, i, 0, g);
    number(io, "tau", relaxation.terms, i, 1, relaxation_time);
    io.end();
    sum += g;
  }
  io.require(sum < 1, "the sum of g is not below 1");
}

/// A TABLE as described in formats/model.md: column scales, then rows of integers.
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

/// Modes that are mixed from shared ones, and the nodes that have rows of their own instead.
/// @param n_shared    of the shared modes
/// @param m           modes
/// @param components  rows for each output node: 3 for displacements, 1 for a scalar field
template <class IO, class Model, class Modes>
void mixed_modes(IO& io, Model& model, Modes& modes, int64_t n_shared, int32_t m, int32_t components) {
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

/// Rows of `displacements` on which kernels are centered.
template <class IO, class Model, class Store>
void amplitude_centers(IO& io, Model& model, Store& centers, int32_t n) {
  rows_of_indices(io, "displacement of a center", centers, n, io.rows(model.displacements));
}

}  // namespace phynness::schema
