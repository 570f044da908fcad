// What the loaders of the families share: lines and tables that are read to memory if there is any.
#pragma once

#include <cmath>

#include "arena.hpp"
#include "model.hpp"
#include "text.hpp"

namespace PHN_RUNTIME {

/// An array that is filled if there is memory and merely read past if not.
template <class T>
class Column {
 public:
  Column(Arena& arena, std::size_t n) : _values(arena.take<T>(n)) {}
  void set(std::size_t i, T value) {
    if (_values) _values[i] = value;
  }
  T* get() const { return _values; }

 private:
  T* _values;
};

/// A copy in the model's memory, if there is any.
template <class T>
const T* place(Arena& arena, const T& value) {
  T* at = arena.take<T>(1);
  if (at) *at = value;
  return at;
}

/// Letters of the text in the model's memory, if there is any, with 0 at the end.
inline const char* place_word(Arena& arena, TextReader::Word word) {
  Column<char> letters(arena, word.length + 1);
  for (std::size_t i = 0; i < word.length; ++i) letters.set(i, word.begin[i]);
  letters.set(word.length, 0);
  return letters.get();
}

inline bool has_memory(const Arena& arena) { return !arena.counting() && !arena.overflow(); }

inline void real_line(TextReader& in, const char* keyword, double* values, int n, bool positive) {
  in.keyword(keyword);
  for (int k = 0; k < n; ++k) values[k] = positive ? in.positive_real() : in.real();
  in.end_line();
}

inline std::int32_t count_line(TextReader& in, const char* keyword, std::int32_t low) {
  in.keyword(keyword);
  const std::int32_t n = in.count(low);
  in.end_line();
  return in.good() ? n : 0;
}

/// The width of a kernel: a Gaussian's spread, a conic section's shape. Outside of 1e-6 ... 1e6 it is
/// refused.
inline double width_line(TextReader& in, const char* keyword) {
  double width = 1;
  real_line(in, keyword, &width, 1, true);
  if (!(width >= 1e-6 && width <= 1e6)) in.fail(PHN_ERROR_RANGE);
  return width;
}

inline double linear_entry(TextReader& in) {
  const double value = in.real();
  if (!(std::fabs(value) <= largest_linear)) in.fail(PHN_ERROR_RANGE);
  return value;
}

inline double coordinate(TextReader& in) {
  const double value = in.real();
  if (!(std::fabs(value) <= largest_coordinate)) in.fail(PHN_ERROR_RANGE);
  return value;
}

/// @param k  xx xy xz yy yz zz
inline void stiffness_line(TextReader& in, double* k) {
  in.keyword("stiffness");
  for (int i = 0; i < 6; ++i) k[i] = linear_entry(in);
  in.end_line();
}

/// Number and table of modes that nodes share.
void load_shared_table(TextReader& in, Arena& arena, std::int32_t n_output, std::int32_t components,
                       SharedTable& shared);
/// Number of modes (line `keyword`) and tables of a node.
void load_tables(TextReader& in, Arena& arena, const char* keyword, std::size_t n_basis,
                 const SharedTable& shared, std::int32_t n_output, ModalTables& tables);

/// A node's response of the full level, with its fields where there is no memory to place them, too.
struct LoadedModal : ModalResponse {
  ModalTables of_field[largest_field_count];
};

/// The fields of a modal model, none if the text has none; and those of a node.
void load_fields(TextReader& in, Arena& arena, phn_model& model);
void load_node_fields(TextReader& in, Arena& arena, phn_model& model, LoadedModal& node);
const ModalTables* load_level_fields(TextReader& in, Arena& arena, const phn_model& level, const LoadedModal& full);

/// The shared part of a modal model. @pre output nodes and displacements of the model are loaded
void load_shared(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model);
/// @param model  its largest sizes are raised to those of this node
LoadedModal load_modal(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model);

/// Centers of amplitudes and what depends on them. @param shared  number and shape are set
void load_amplitude_centers(TextReader& in, Arena& arena, std::int32_t n_displacements, const phn_model& model,
                            SharedModes& shared);

/// Smaller levels while a model is loaded: which of what they are made of is their own.
struct Levels {
  std::int32_t n_smaller;
  phn_model level[largest_level_count - 1];           ///< shared, errors; all else when the model is complete
  ActiveNode* active[largest_level_count - 1];        ///< n_active each, or null
};
/// The levels of a model, one if the text says nothing of them.
void load_levels(TextReader& in, Arena& arena, std::int32_t n_displacements, phn_model& model, Levels& levels);
/// Number of modes and weights of the amplitudes. @param tables  of the full level
void load_level_weights(TextReader& in, Arena& arena, const char* keyword, std::size_t n_kernels, ModalTables& tables);
ModalResponse load_modal_level(TextReader& in, Arena& arena, std::int32_t n_displacements, const phn_model& level,
                               const LoadedModal& full);
/// @param model  complete; @param memory n_smaller of them, or null
void place_levels(const phn_model& model, const Levels& levels, phn_model* memory);

}  // namespace PHN_RUNTIME
