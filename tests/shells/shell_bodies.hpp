// Middle surfaces for tests, with supports and loads.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <phynness/formats/mesh.hpp>
#include <vector>

#include "body_states.hpp"
#include "solver_cases.hpp"

namespace phynness::test {

/// n[0] x n[1] squares of two triangles each over [0, 1]^2, put in space by `at`.
template <class At>
Mesh shell_mesh(std::array<int, 2> n, At&& at) {
  Mesh mesh;
  mesh.nodes.resize((n[0] + 1) * (n[1] + 1), 3);
  mesh.cells.resize(2 * n[0] * n[1], 3);
  for (int j = 0; j <= n[1]; ++j)
    for (int i = 0; i <= n[0]; ++i)
      mesh.nodes.row(j * (n[0] + 1) + i) = at(static_cast<double>(i) / n[0], static_cast<double>(j) / n[1]).transpose();
  for (int j = 0, t = 0; j < n[1]; ++j)
    for (int i = 0; i < n[0]; ++i) {
      const int a = j * (n[0] + 1) + i, b = a + n[0] + 1;
      mesh.cells.row(t++) << a, a + 1, b + 1;
      mesh.cells.row(t++) << a, b + 1, b;
    }
  mesh.surface = mesh.cells;
  return mesh;
}

inline Mesh strip(double length, double width, std::array<int, 2> n) {
  return shell_mesh(n, [&](double s, double t) { return Vector3(length * s, width * t, 0); });
}

/// A quarter of a cylinder of radius 1 and length 1.
inline Mesh arch(int n) {
  return shell_mesh({n, n}, [](double s, double t) -> Vector3 {
    const double angle = s * std::numbers::pi / 2;
    return {std::cos(angle), std::sin(angle), t};
  });
}

/// That have a shell.
inline std::vector<Law> shell_laws() {
  std::vector<Law> result;
  for (const auto& law : laws())
    if (law.has_shell) result.push_back(&law);
  return result;
}

/// Dofs of displacements and directors at places X, chosen component by component.
template <class Chosen>
std::vector<std::int32_t> shell_dofs(const Discretization& body, Chosen&& chosen, bool displacements = true,
                                     bool directors = true) {
  std::vector<std::int32_t> dofs;
  for (int p = 0; p < body.n_points(); ++p)
    for (int k = 0; k < 3; ++k) {
      const Vector3 X = body.points().row(p).transpose();
      if (!chosen(X, k)) continue;
      if (displacements) dofs.push_back(body.dofs(p)[k]);
      if (directors && p >= body.n_nodes()) dofs.push_back(body.director_dofs(p)[k]);
    }
  return dofs;
}

/// A shell of Hooke's moduli that is not stretched much: St. Venant-Kirchhoff with the shear modulus as the unit.
struct ThinShell {
  double youngs_modulus, poissons_ratio, thickness;
  double shear_modulus() const { return youngs_modulus / (2 * (1 + poissons_ratio)); }
  FormSet forms() const {
    const auto material = hookean(law_named("st-venant-kirchhoff"), youngs_modulus, poissons_ratio);
    return form_set(material, element_named("shell"), shear_modulus(), thickness);
  }
};

inline SolverSpec shell_solver() {
  SolverSpec spec;
  spec.element = element_named("shell");
  spec.max_iterations = 300;  // thin shells under dead loads: what is stiff changes its direction at every step
  return spec;
}

}  // namespace phynness::test
