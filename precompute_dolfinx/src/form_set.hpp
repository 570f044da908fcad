// What ffcx compiled for one material and one element, with the constants that go in.
#pragma once

#include <ufcx.h>

#include <array>
#include <map>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Constants by their names in the UFL file, without dimension.
using FormConstants = std::map<std::string, double>;

/// What ffcx compiled; the build writes the table (forms/tables.py).
struct CompiledForms {
  const ufcx_form* energy = nullptr;
  const ufcx_form* residual = nullptr;
  const ufcx_form* tangent = nullptr;
  std::array<const ufcx_form*, every_field.size()> fields{};  ///< functionals: integrals, not negative in any cell
  const ufcx_expression* jacobian = nullptr;                  ///< J = det F at the quadrature points
  /// Shells only, added to the first three: what keeps directors at their length.
  const ufcx_form *gauge_energy = nullptr, *gauge_residual = nullptr, *gauge_tangent = nullptr;
};

/// @pre the law has a shell if the element is one
CompiledForms compiled_forms(Law law, Element element);

struct FormSet : CompiledForms {
  Element element = nullptr;
  FormConstants constants;
  /// Constants that change from pass to pass: energy, residual and tangent are sums over these, and min_jacobian()
  /// is the smallest. A solid has one pass, a shell one for every layer.
  std::vector<FormConstants> passes{{}}, jacobian_passes{{}};
  bool checks_jacobian = true;  ///< false for the linear theory, which knows no J
};

/// Coefficient alpha of the p1-p1 stabilization; forms/mechanics.py has the formula.
/// Stiffness hardly depends on it (DESIGN: 16.2 to 13.3 N/m from 0.005 to 0.3).
inline constexpr double stabilization_alpha = 0.05;

/// @param modulus_Pa  the unit of moduli (Scaling::modulus_Pa)
/// @param thickness   of a shell, in units of length (Scaling::length_m)
FormSet form_set(const Material& material, Element element, double modulus_Pa, double thickness = 0);

}  // namespace phynness
