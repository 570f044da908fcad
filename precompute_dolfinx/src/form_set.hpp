// What ffcx compiled for one material and one element, with the constants that go in.
#pragma once

#include <ufcx.h>

#include <map>
#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

struct FormSet {
  const ufcx_form* energy = nullptr;
  const ufcx_form* residual = nullptr;
  const ufcx_form* tangent = nullptr;
  const ufcx_form* von_mises = nullptr;       ///< functional: integral of the von Mises stress
  const ufcx_form* stored = nullptr;          ///< functional: the energy, not negative in any cell
  const ufcx_expression* jacobian = nullptr;  ///< J = det F at the quadrature points
  Element element = Element::p1;
  std::map<std::string, double> constants;  ///< by their names in the UFL file, without dimension
  bool checks_jacobian = true;              ///< false for the linear theory, which knows no J
};

/// Coefficient alpha of the p1-p1 stabilization; forms/mechanics.py has the formula.
/// Stiffness hardly depends on it (DESIGN: 16.2 to 13.3 N/m from 0.005 to 0.3).
inline constexpr double stabilization_alpha = 0.05;

/// @param modulus_Pa  the unit of moduli (Scaling::modulus_Pa)
FormSet form_set(const Material& material, Element element, double modulus_Pa);

}  // namespace phynness
