// Claim: for a smooth solution the displacement error decreases with the order of the element: 1 in H1 and 2 in L2 with
// P1, p1-p1 and es-p1-p1, 2 and 3 with P2 and Taylor-Hood. Higher orders fail the test as well as lower ones. A
// solution whose strain and pressure jump at an interface of materials has the same orders.
#include <gtest/gtest.h>
#include <manufactured.h>

#include "block_mesh.hpp"
#include "body_states.hpp"
#include "dense_tangent.hpp"
#include "layers.hpp"
#include "solver_cases.hpp"

namespace phynness::test {
namespace {

/// The forms of manufactured.py for an element, in the places of a FormSet that hold a functional and a linear form.
struct ErrorForms {
  const ufcx_form *L2, *H1, *load;
};
ErrorForms error_forms(Element element) {
  if (element == element_named("P1"))
    return {form_manufactured_p1_L2, form_manufactured_p1_H1, form_manufactured_p1_load};
  if (element == element_named("P2"))
    return {form_manufactured_p2_L2, form_manufactured_p2_H1, form_manufactured_p2_load};
  if (element == element_named("taylor-hood"))
    return {form_manufactured_th_L2, form_manufactured_th_H1, form_manufactured_th_load};
  return {form_manufactured_p1p1_L2, form_manufactured_p1p1_H1, form_manufactured_p1p1_load};
}

const Eigen::Matrix3d H{{0.06, 0.15, -0.10}, {0.05, -0.04, 0.12}, {0.03, -0.04, 0.02}};

/// @param a  of manufactured.py above z = 1/2
Vector3 exact(const Vector3& X, const Vector3& a) {
  const double s = X[2] - 0.5;
  return H * X + std::max(s, 0.0) * a +
         0.3 * s * s *
             Vector3(std::sin(X[0] + 0.5 * X[1]), std::cos(0.5 * X[0] + X[2]) + 0.5 * X[0] * X[1],
                     std::sin(X[1]) - 0.5 * X[0] * X[0]);
}

struct Errors {
  double L2 = 0, H1 = 0;
};

/// Solves with exact values on the boundary of the unit cube and the body force inside; n boxes an edge.
/// @param ratio  of the moduli above z = 1/2; 1: there is no region
Errors errors(Element element, int n, double ratio) {
  const auto mesh = block_mesh({n, n, n}, {1, 1, 1});
  const auto material = unit_material(law_named("neo-hookean"), 10);
  const Material above = times(ratio, material);
  const Vector3 a = jump_of_strain(material, above, H);
  auto forms = form_set(material, element, 1, 0, {above});
  for (int k = 0; k < 3; ++k) {
    forms.constants["a" + std::to_string(k)] = 0;
    forms.regions[0].constants["a" + std::to_string(k)] = a[k];
  }
  std::vector<std::uint8_t> regions;
  for (Eigen::Index c = 0; c < mesh.cells.rows() && ratio != 1; ++c) {
    double z = 0;
    for (int i = 0; i < 4; ++i) z += mesh.nodes(mesh.cells(c, i), 2) / 4;
    regions.push_back(z > 0.5 ? 1 : 0);
  }
  Discretization body(mesh, forms, regions);
  std::vector<std::int32_t> boundary;
  for (int p = 0; p < body.n_points(); ++p)
    if (body.on_surface(p)) boundary.insert(boundary.end(), body.dofs(p).begin(), body.dofs(p).end());

  const auto [L2, H1, load] = error_forms(element);
  forms.edges = {};
  forms.residual = load;
  forms.energy = L2;
  Discretization measuring_L2(mesh, forms, regions);
  forms.energy = H1;
  Discretization measuring_H1(mesh, forms, regions);

  SolverSpec spec;
  spec.element = element;
  spec.relative_tolerance = 1e-10;
  Equilibrium equilibrium(body, boundary, spec);
  std::vector<double> body_force(body.n_dofs());
  measuring_L2.residual(std::vector<double>(body.n_dofs(), 0.0), body_force);
  const DeadLoad load_of_body(body_force);
  body.set_extra_energy(&load_of_body);

  // Newton starts inside with a displacement that is 10 % off, so that interpolation alone passes no test.
  auto state = state_of(body, [&](const Vector3& X) { return exact(X, a); });
  for (int p = 0; p < body.n_points(); ++p)
    if (!body.on_surface(p))
      for (const auto dof : body.dofs(p)) state[dof] *= 0.9;
  const auto outcome = equilibrium.solve(state);
  EXPECT_EQ(outcome.status, Status::converged);
  EXPECT_GT(outcome.iterations, 1);
  return {std::sqrt(measuring_L2.energy(state)), std::sqrt(measuring_H1.energy(state))};
}

struct Expected {
  Element element;
  int coarse;           ///< boxes an edge, even; the fine mesh has twice as many
  double H1[2], L2[2];  ///< bounds of the observed orders
};

class Orders : public ::testing::TestWithParam<Expected> {};

TEST_P(Orders, AreThoseOfTheElement) {
  const auto& [element, coarse, expected_H1, expected_L2] = GetParam();
  for (const double ratio : {1.0, 8.0}) {
    SCOPED_TRACE(ratio);
    const auto at_h = errors(element, coarse, ratio), at_half_h = errors(element, 2 * coarse, ratio);
    const double H1 = std::log2(at_h.H1 / at_half_h.H1), L2 = std::log2(at_h.L2 / at_half_h.L2);
    std::printf("%s, ratio %g: H1 %.3e -> %.3e, order %.2f; L2 %.3e -> %.3e, order %.2f\n", name(element), ratio,
                at_h.H1, at_half_h.H1, H1, at_h.L2, at_half_h.L2, L2);
    EXPECT_GT(H1, expected_H1[0]);
    EXPECT_LT(H1, expected_H1[1]);
    EXPECT_GT(L2, expected_L2[0]);
    EXPECT_LT(L2, expected_L2[1]);
  }
}

// A structured mesh gives the displacement elements their orders within 0.1. Mixed elements start from the larger error
// of their pressure, at K/mu = 10 that of kappa J, and come down on the displacement's own from above: Taylor-Hood some
// tenths too fast, p1-p1, whose stabilization is of order between 1 and 2 in the pressure, visibly so. Their L2 order
// still rises: at the interface 1.48 and 1.36 here, 1.67 and 1.56 from 8 boxes an edge on.
INSTANTIATE_TEST_SUITE_P(Elements, Orders,
                         ::testing::Values(Expected{element_named("P1"), 4, {0.9, 1.1}, {1.8, 2.1}},
                                           Expected{element_named("P2"), 4, {1.9, 2.1}, {2.8, 3.2}},
                                           Expected{element_named("taylor-hood"), 4, {1.9, 2.4}, {2.8, 3.5}},
                                           Expected{element_named("p1-p1"), 6, {0.9, 1.5}, {1.3, 2.2}},
                                           Expected{element_named("es-p1-p1"), 6, {0.9, 1.5}, {1.3, 2.2}}),
                         [](const auto& info) {
                           return element_name({info.param.element, 0});
                         });

}  // namespace
}  // namespace phynness::test
