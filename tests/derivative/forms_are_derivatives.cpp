// Claim: the residual is the derivative of the energy, and the tangent is the derivative of the residual and therefore
// symmetric, for every law and element at a general deformed state.
//
// The five-point difference quotient has a truncation error of h^4/30 times the fifth derivative along the direction,
// and a rounding error of 1e-16/h. With h = 1e-3 and states with derivatives of order 1 to 10 (J is not close to 0)
// both are below 1e-11. The tolerance of 1e-8 of the norm allows for the fifth derivatives of ln J and J^(-2/3).
#include <gtest/gtest.h>

#include "../shells/shell_bodies.hpp"
#include "block_mesh.hpp"
#include "dense_tangent.hpp"

namespace phynness::test {
namespace {

constexpr double step = 1e-3, tolerance = 1e-8;

/// f'(0) for numbers and vectors.
template <typename F>
auto derivative_at_zero(F&& f) {
  using Value = decltype(f(0.0));
  return Value((8 * (f(step) - f(-step)) - (f(2 * step) - f(-2 * step))) / (12 * step));
}

class Forms : public ::testing::TestWithParam<Case> {
 protected:
  /// A state with J > 0 everywhere, and a direction of unit length to vary it along.
  void SetUp() override {
    const auto mesh = _is_shell ? arch(3) : irregular(block_mesh({2, 2, 2}, {1, 1, 1}), 0.1, _random);
    _body = std::make_unique<Discretization>(
        mesh, form_set(unit_material(GetParam().law, _is_shell ? 50 : 10), GetParam().element, 1, _is_shell ? 0.1 : 0));
    _state = state_of(*_body, [&](const Vector3& X) -> Vector3 {
      const Vector3 noise(_random(), _random(), _random());
      return Vector3(0.2 * X[0] + 0.3 * X[1], -0.1 * X[1] + 0.1 * X[2], 0.15 * X[2] - 0.2 * X[0]) + 0.02 * noise;
    });
    for (const auto dof : _body->pressure_dofs()) _state[dof] = _random();
    if (_is_shell)
      for (auto& value : _state) value = 0.02 * _random();
    else
      ASSERT_GT(_body->min_jacobian(_state), 0.3);
    _direction.resize(_body->n_dofs());
    for (auto& d : _direction) d = _random();
    _direction.normalize();
  }

  std::vector<double> moved(double t) const {
    auto state = _state;
    for (int i = 0; i < _body->n_dofs(); ++i) state[i] += t * _direction[i];
    return state;
  }

  const bool _is_shell = GetParam().element->is_shell;
  Random _random{23};
  std::unique_ptr<Discretization> _body;
  std::vector<double> _state;
  Eigen::VectorXd _direction;
};

TEST_P(Forms, ResidualIsTheDerivativeOfTheEnergy) {
  const double expected = derivative_at_zero([&](double t) { return _body->energy(moved(t)); });
  const auto r = residual(*_body, _state);
  EXPECT_NEAR(r.dot(_direction), expected, tolerance * r.norm());
}

TEST_P(Forms, TangentIsTheDerivativeOfTheResidualAndSymmetric) {
  const Eigen::VectorXd expected = derivative_at_zero([&](double t) { return residual(*_body, moved(t)); });
  const auto K = dense_tangent(*_body, _state);
  EXPECT_LT((K * _direction - expected).norm(), tolerance * expected.norm());
  // The kernels sum rows and columns in different orders: rounding only.
  EXPECT_LT((K - K.transpose()).norm(), (_is_shell ? 1e-12 : 1e-13) * K.norm());
}

std::vector<Case> shell_cases() {
  std::vector<Case> cases;
  for (const Law law : shell_laws()) cases.push_back({law, element_named("shell")});
  return cases;
}
INSTANTIATE_TEST_SUITE_P(Laws, Forms, ::testing::ValuesIn(every_case()), case_name);
INSTANTIATE_TEST_SUITE_P(Shells, Forms, ::testing::ValuesIn(shell_cases()), case_name);

}  // namespace
}  // namespace phynness::test
