#include <gtest/gtest.h>

#include "loaded_model.hpp"
#include "small_model.hpp"

namespace {

using namespace phynness;
using namespace phynness::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

class DerivativesOf : public testing::TestWithParam<Family> {};
INSTANTIATE_TEST_SUITE_P(Families, DerivativesOf, testing::Values(Family::linear, Family::modal),
                         [](const auto& info) { return std::string(name(info.param)); });

struct Derivatives {
  double energy;
  Vector3d force;
  Matrix3d stiffness;
};

Derivatives response(const LoadedModel& loaded, std::int32_t node, const Vector3d& d) {
  Derivatives r;
  EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node, d.data()), nullptr, &r.energy, nullptr), 0);
  EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node, d.data()), r.force.data(), nullptr, nullptr), 0);
  EXPECT_GE(phn_force(loaded.model, loaded.data, AtNode(node, d.data()), nullptr, nullptr, r.stiffness.data()), 0);
  return r;
}

/// Fourth-order central difference of f along t at 0, step h.
template <class F>
auto difference(F f, double h) -> decltype(f(h)) {
  return (8.0 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}

// Claim: force is the gradient of the energy and stiffness the derivative of the force. Steps of a thousandth
// of the largest displacement R: truncation (h / shape)^4 / 30 = 4e-12 of higher derivatives, rounding 1e-16
// R / h = 1e-13 of the sizes of the terms; 1e-9 leaves room for both.
TEST_P(DerivativesOf, EqualFiniteDifferences) {
  const Model model = small_model_of(GetParam());
  const LoadedModel loaded(write_model_text(model));
  const double h = 1e-3 * model.max_displacement_m;
  Numbers numbers;
  for (const ActiveNodeModel& node : model.nodes)
    for (int trial = 0; trial < 20; ++trial) {
      Vector3d d;
      for (int k = 0; k < 3; ++k) d[k] = 1.5 * model.max_displacement_m * numbers.next();
      const Derivatives at = response(loaded, node.node, d);
      for (int k = 0; k < 3; ++k) {
        const auto along = [&](double t) { return response(loaded, node.node, d + t * Vector3d::Unit(k)); };
        const double slope = difference([&](double t) { return along(t).energy; }, h);
        const Vector3d column = difference([&](double t) -> Vector3d { return along(t).force; }, h);
        EXPECT_NEAR(slope, at.force[k], 1e-9 * at.force.norm());
        EXPECT_LT((column - at.stiffness.col(k)).norm(), 1e-9 * at.stiffness.norm());
      }
      EXPECT_EQ(at.stiffness, at.stiffness.transpose());
    }
}

// Claim: whatever is asked for together, force, energy and stiffness have the bits that they have when asked for alone.
TEST_P(DerivativesOf, HaveTheSameBitsInAnyCall) {
  const Model model = small_model_of(GetParam());
  const LoadedModel loaded(write_model_text(model));
  Numbers numbers;
  for (const ActiveNodeModel& node : model.nodes)
    for (int trial = 0; trial < 20; ++trial) {
      const Vector3d d = 1.5 * model.max_displacement_m * numbers.vector();
      const Derivatives alone = response(loaded, node.node, d);
      for (int asked = 1; asked < 8; ++asked) {
        const bool force = asked & 1, energy = asked & 2, stiffness = asked & 4;
        Derivatives r{-1, Vector3d::Constant(-1), Matrix3d::Constant(-1)};
        ASSERT_GE(phn_force(loaded.model, loaded.data, AtNode(node.node, d.data()), force ? r.force.data() : nullptr,
                            energy ? &r.energy : nullptr, stiffness ? r.stiffness.data() : nullptr),
                  0);
        EXPECT_EQ(r.force, force ? alone.force : Vector3d::Constant(-1)) << asked;
        EXPECT_EQ(r.energy, energy ? alone.energy : -1) << asked;
        EXPECT_EQ(r.stiffness, stiffness ? alone.stiffness : Matrix3d::Constant(-1)) << asked;
      }
    }
}

}  // namespace
