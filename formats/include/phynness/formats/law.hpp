// Laws and elements as tables. The build makes the rows from precompute_dolfinx/laws/*.py and from
// precompute_dolfinx/forms/element_table.py; nothing else knows how many there are.
#pragma once

#include <span>
#include <string_view>

namespace phynness {

/// Moduli at rest in Pa, whatever the law: mu, lambda = K - 2 mu / 3, K.
struct Moduli {
  double shear_modulus_Pa = 0, lame_lambda_Pa = 0, bulk_modulus_Pa = 0;
};

/// A constant of a law's energy.
struct LawParameter {
  const char* key;       ///< in a scene, with its unit
  const char* constant;  ///< in the compiled forms
  bool is_modulus;       ///< in Pa; otherwise without unit
};

/// A number of [material]: low .. high, with the ends themselves refused where `open`.
struct LawKey {
  const char* key;
  double low, high;
  bool low_open, high_open;
};

/// What a given number must be in view of the others: greater, or less, than value(given).
struct LawBound {
  int given;  ///< which of them
  bool greater;
  double (*value)(const double* given);
  const char *what, *remedy;  ///< what goes wrong otherwise; what the remedy starts with
};

/// Numbers that determine a material.
struct LawSet {
  std::span<const LawKey> given;
  std::span<const LawBound> bounds;
  /// @param given  one number for each key
  /// @param parameters  gets one for each of the law's parameters
  void (*convert)(const double* given, double* parameters, Moduli& moduli);
};

/// A constant of the forms that follows from the parameters; without unit.
struct LawConstant {
  const char* name;
  double (*value)(const double* parameters);
};

struct LawRow {
  const char* name;  ///< in a scene
  std::span<const LawParameter> parameters;
  std::span<const LawSet> accepted;
  std::span<const LawConstant> derived;
  bool linear;        ///< small strains: force is proportional to displacement, and there is no J
  bool has_shell;     ///< its stress across a shell's wall is condensed
  double shell_from;  ///< smallest K/mu of a shell
};
/// Two are equal where they are the same row.
using Law = const LawRow*;

struct ElementRow {
  const char* name;  ///< in a scene
  int displacement_degree;
  bool mixed;           ///< displacement and pressure, which is linear
  bool is_shell;        ///< of triangles; the others are of tetrahedra
  double locks_above;   ///< K/mu from which on it is too stiff
  bool locks_severely;  ///< several times; otherwise noticeably
};
using Element = const ElementRow*;

/// Every law, in the order of its file's name.
std::span<const LawRow> laws();
/// Every element, the shell last.
std::span<const ElementRow> elements();
/// @throws Error (input) if there is none of that name
Law law_named(std::string_view name);
Element element_named(std::string_view name);

inline const char* name(Law law) { return law->name; }
inline const char* name(Element element) { return element->name; }

}  // namespace phynness
