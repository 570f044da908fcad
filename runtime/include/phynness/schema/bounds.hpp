// Bounds of the numbers of a model.txt (formats/model.md). Within them no sum of an evaluation overflows.
#pragma once

#include <float.h>
#include <stdint.h>

namespace phynness::schema {

/// Components of displacements are clamped to these, in m (linear) or in max_displacement_m (modal).
inline constexpr double largest_linear_displacement = 1e100, largest_modal_displacement = 1e6;

/// Largest magnitude of a stiffness [N/m], a coefficient [N] or a unit response.
inline constexpr double largest_linear_entry = 1e100;
/// Largest magnitude of an undeformed coordinate [m]; distances and products of four of them remain finite.
inline constexpr double largest_coordinate = 1e30;
/// Largest width of a kernel; its inverse is the smallest. Beyond these a Gaussian is practically a spike or a
/// constant.
inline constexpr double largest_width = 1e6;
inline constexpr int32_t largest_table_entry = 32767;
/// Largest magnitude of a value of a table of scaled integers.
inline constexpr double largest_table_value = 1e6;
inline constexpr int32_t largest_mode_count = 1024, largest_field_count = 8, largest_level_count = 8;
inline constexpr int32_t largest_bound_count = 1;
/// Finer solutions from which a bound may state the distance: taylor-hood, half-size.
inline constexpr int32_t n_bound_references = 2;
/// Coefficients of the bound of a tool between nodes (formats/model.md, Bounds); of one tool, of two, and of three or
/// more on a body (formats/body.md, Bounds).
inline constexpr int32_t n_coupled_kinds = 3, n_coupled_terms = 4;
/// The first coefficient of a bound that is not known, with which it is PHN_NO_BOUND; the others are 0.
inline constexpr double no_coupled_bound = 1e3;
/// The weights of a covered node are integers, parts of this.
inline constexpr int32_t whole_weight = 65535;
/// Neighbours of a probed point in equation (x) of docs/theory.md; with fewer than enough it has those of them, too.
inline constexpr int32_t most_neighbours = 7, enough_neighbours = 5;
/// Terms of a Prony series.
inline constexpr int32_t largest_relaxation_count = 8;
/// Characters of the name or unit of a field.
inline constexpr int32_t longest_word = 40;
/// Terms of an amplitude beside its kernels: x, y and z; for a field also the six products of two of them.
inline constexpr int32_t n_linear_terms = 3, n_field_terms = 9;

/// A closed range of numbers, and the words of the error message for a number outside of it.
struct Bound {
  double low, high;
  const char* outside;
};
inline constexpr Bound any_number{-DBL_MAX, DBL_MAX, "is not finite"};
inline constexpr Bound positive{DBL_TRUE_MIN, DBL_MAX, "must be positive"};
inline constexpr Bound body_depth{1e-90, 1e90, "is out of range 1e-90 ... 1e90 m"};
inline constexpr Bound not_negative{0, DBL_MAX, "is negative"};
inline constexpr Bound coordinate{-largest_coordinate, largest_coordinate, "is beyond 1e30 m"};
inline constexpr Bound linear_entry{-largest_linear_entry, largest_linear_entry, "is beyond 1e100"};
inline constexpr Bound probe_weight{-1, 1, "is beyond 1"};
inline constexpr Bound width{1 / largest_width, largest_width, "is out of range 1e-6 ... 1e6"};
inline constexpr Bound field_scale{DBL_TRUE_MIN, largest_linear_entry, "is not positive or beyond 1e100"};
inline constexpr Bound level_error{0, largest_linear_entry, "is negative or beyond 1e100"};
inline constexpr Bound exponent{-1e3, 1e3, "is beyond 1000"};
inline constexpr Bound probability{0, 1, "is not between 0 and 1"};
inline constexpr Bound relaxing_share{1e-9, 1, "is not between 0 and 1"};
inline constexpr Bound relaxation_time{1e-9, 1e9, "is out of range 1e-9 ... 1e9 s"};
inline constexpr Bound table_scale{0, largest_table_value / largest_table_entry, "is negative or too large"};

}  // namespace phynness::schema
