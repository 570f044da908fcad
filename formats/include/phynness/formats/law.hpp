// Tables of material laws and elements. The build generates the rows from laws/*.py and
// laws/tables/element_table.py; no other code depends on their number.
#pragma once

#include <span>
#include <string_view>

namespace phynness {

/// Moduli at rest [Pa] of any law: mu, lambda = K - 2 mu / 3, K.
struct Moduli {
  double shear_modulus_Pa = 0, lame_lambda_Pa = 0, bulk_modulus_Pa = 0;
};

/// A constant of a law's energy.
struct LawParameter {
  const char* key;       ///< key in a scene, with its unit
  const char* constant;  ///< name in the compiled forms
  bool is_modulus;       ///< in Pa; otherwise dimensionless
};

/// A number of [material] from low to high, where the end is excluded if `open`.
struct LawKey {
  const char* key;
  double low, high;
  bool low_open, high_open;
};

/// A bound of a number that depends on the other numbers: it must be greater, or less, than value(given).
struct LawBound {
  int given;  ///< index of the number
  bool greater;
  double (*value)(const double* given);
  const char *what, *remedy;  ///< what is wrong outside of the bound; start of the remedy
};

/// A set of numbers that determines a material.
struct LawSet {
  std::span<const LawKey> given;
  std::span<const LawBound> bounds;
  /// @param given  one number for each key
  /// @param parameters  output, one number for each parameter of the law
  void (*convert)(const double* given, double* parameters, Moduli& moduli);
};

/// A dimensionless constant of the forms that follows from the parameters.
struct LawConstant {
  const char* name;
  double (*value)(const double* parameters);
};

struct LawRow {
  const char* name;  ///< in a scene
  std::span<const LawParameter> parameters;
  std::span<const LawSet> accepted;
  std::span<const LawConstant> derived;
  bool linear;        ///< small strains: force is proportional to displacement, and J is not computed
  bool isochoric;     ///< K multiplies the volumetric energy; the rest does not see changes of volume
  bool has_shell;     ///< available for shells, by condensation of the stress across the wall
  double shell_from;  ///< smallest K/mu of a shell
};
/// Laws are equal if they are the same row.
using Law = const LawRow*;

/// Size of an element's force over that of an element that does not lock, on the same mesh, in the mean over measured
/// probes of both kinds.
struct ForceRatio {
  double bulk_to_shear;
  double patch;  ///< over Taylor-Hood
  double node;   ///< over the mixed element that holds the same points
};

struct ElementRow {
  const char* name;  ///< in a scene
  int displacement_degree;
  bool mixed;                                ///< has displacement and linear pressure
  bool is_shell;                             ///< made of triangles; other elements are tetrahedra
  std::span<const ForceRatio> force_ratios;  ///< by ascending K/mu; empty: the element does not lock
};
using Element = const ElementRow*;
/// Whether databases of the element can be reduced to a body (training/reduction.hpp): p1-p1 and es-p1-p1.
inline bool has_bodies(const ElementRow& element) { return element.mixed && element.displacement_degree == 1; }

/// Coefficient alpha of the p1-p1 stabilization (precompute_dolfinx/forms/mechanics.py). On coarse meshes forces depend
/// on it: those of round tools are off by 15 % in the median, with 0.5 by 7 %, but pressures and displacements by more
/// than with 0.05 (docs/decisions/element.md).
inline constexpr double stabilization_alpha = 0.05;

/// Of edge-smoothed elements: alpha, and the share of the shear energy that remains in the cells. Without it one deep
/// ray of nine ends in crushed cells, whose neighbors keep the mean gradients regular; with it forces at rest are 2 %
/// larger (docs/decisions/element.md).
inline constexpr double smoothed_alpha = 0.1, cell_share = 0.1;

/// All laws, in the order of their file names.
std::span<const LawRow> laws();
/// All elements; the shell is the last.
std::span<const ElementRow> elements();
/// @throws Error (input) if there is no law or element of that name
Law law_named(std::string_view name);
Element element_named(std::string_view name);

inline const char* name(Law law) { return law->name; }
inline const char* name(Element element) { return element->name; }

}  // namespace phynness
