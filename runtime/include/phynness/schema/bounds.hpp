// Bounds of what a model.txt holds (formats/model.md). Within them no sum of an evaluation overflows.
#pragma once

#include <float.h>
#include <stdint.h>

namespace phynness::schema {

/// Displacements are cut to this size per component, in the unit that a family evaluates in.
inline constexpr double largest_linear_displacement = 1e100, largest_modal_displacement = 1e6;

/// Size of a stiffness [N/m], of a coefficient [N], of a unit response.
inline constexpr double largest_linear_entry = 1e100;
/// Size of a reference coordinate [m]: distances and products of four of them stay finite.
inline constexpr double largest_coordinate = 1e30;
/// Width of a kernel, 1 over it the least: beyond it a Gaussian is a spike or a constant.
inline constexpr double largest_width = 1e6;
inline constexpr int32_t largest_table_entry = 32767;
/// Size of a value of a table of scaled integers.
inline constexpr double largest_table_value = 1e6;
inline constexpr int32_t largest_mode_count = 1024, largest_field_count = 8, largest_level_count = 8;
/// Characters of the name or unit of a field.
inline constexpr int32_t longest_word = 40;
/// Kernels of amplitudes beside their centers: x, y, z, and of a field the six products of two of them.
inline constexpr int32_t n_linear_terms = 3, n_field_terms = 9;

/// A closed range of numbers and how a number outside of it is described.
struct Bound {
  double low, high;
  const char* outside;
};
inline constexpr Bound any_number{-DBL_MAX, DBL_MAX, "is not finite"};
inline constexpr Bound positive{DBL_TRUE_MIN, DBL_MAX, "must be positive"};
inline constexpr Bound not_negative{0, DBL_MAX, "is negative"};
inline constexpr Bound coordinate{-largest_coordinate, largest_coordinate, "is beyond 1e30 m"};
inline constexpr Bound linear_entry{-largest_linear_entry, largest_linear_entry, "is beyond 1e100"};
inline constexpr Bound probe_weight{-1, 1, "is beyond 1"};
inline constexpr Bound width{1 / largest_width, largest_width, "is out of range 1e-6 ... 1e6"};
inline constexpr Bound field_scale{DBL_TRUE_MIN, largest_linear_entry, "is not positive or beyond 1e100"};
inline constexpr Bound level_error{0, largest_linear_entry, "is negative or beyond 1e100"};
inline constexpr Bound table_scale{0, largest_table_value / largest_table_entry, "is negative or too large"};

}  // namespace phynness::schema
