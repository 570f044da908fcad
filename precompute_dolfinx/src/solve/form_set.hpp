// The compiled forms of a material and an element, with their constants.
#pragma once

#include <ufcx.h>

#include <array>
#include <map>
#include <phynness/formats/scene.hpp>
#include <string>
#include <vector>

namespace phynness {

/// Dimensionless constants by their names in the UFL file.
using FormConstants = std::map<std::string, double>;

/// Forms of the edges of an edge-smoothed element (edge_patches.hpp), functions of a mean deformation gradient.
struct EdgeForms {
  const ufcx_form *energy = nullptr, *residual = nullptr, *tangent = nullptr;
  const ufcx_expression* jacobian = nullptr;
};

/// Forms compiled by ffcx; the build generates their table (laws/tables/tables.py).
struct CompiledForms {
  const ufcx_form* energy = nullptr;
  const ufcx_form* residual = nullptr;
  const ufcx_form* tangent = nullptr;
  std::array<const ufcx_form*, every_field.size()> fields{};  ///< functionals, >= 0 in every cell
  const ufcx_expression* jacobian = nullptr;                  ///< J = det F at the quadrature points
  /// Shells only, added to the first three: penalty that keeps the length of directors.
  const ufcx_form *gauge_energy = nullptr, *gauge_residual = nullptr, *gauge_tangent = nullptr;
  EdgeForms edges;  ///< added to the first three; null for elements that are not edge-smoothed
};

/// @pre the law is available for shells if the element is a shell
CompiledForms compiled_forms(Law law, Element element);

struct FormSet : CompiledForms {
  Element element = nullptr;
  FormConstants constants;
  /// The cells of region i + 1 have these constants in place of the body's, and pressures in units of its shear
  /// modulus.
  struct Region {
    FormConstants constants;
    double shear_modulus = 1;  ///< in units of moduli
  };
  std::vector<Region> regions;
  /// Constants that differ between passes. Energy, residual and tangent are sums over the passes, and min_jacobian() is
  /// the minimum. A solid has one pass, a shell has several.
  std::vector<FormConstants> passes{{}}, jacobian_passes{{}};
  bool checks_jacobian = true;  ///< false for the linear theory, in which J has no meaning

  int n_regions() const { return static_cast<int>(regions.size()) + 1; }
  FormConstants constants_in(int region, FormConstants of_pass = {}) const;
};

/// @param modulus_Pa  the unit of moduli (Scaling::modulus_Pa)
/// @param thickness   of a shell, in units of length (Scaling::length_m)
/// @param regions     materials of regions 1, 2, ..., all of the body's law
FormSet form_set(const Material& material, Element element, double modulus_Pa, double thickness = 0,
                 const std::vector<Material>& regions = {});

}  // namespace phynness
