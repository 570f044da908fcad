// Force, energy and stiffness of family modal. They are derivatives of one potential: sums over the same centers.
// Templates on the scalar type, so that the effect of rounding on closed paths can also be measured in float, and on
// the type that holds the coefficients: a model (Conservative) or an image (image.hpp).
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "square_root.hpp"
#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// With x = d / R, q(y) = sqrt(|y|^2 + shape^2) and b_i the coefficients:
///   force = K d + sum_i [Phi(x - c_i) - Phi(x) - Phi(c_i) + Phi(0)] b_i,  Phi(y) = q I + y y^T / q
/// The evaluation has one more center, at 0 with the coefficient -sum_i b_i, for the terms -Phi(x). Constants make
/// force and energy at rest exactly 0.
template <class Real>
struct Conservative {
  int32_t n_centers;
  Real max_displacement;        ///< R [m]
  Real shape;                   ///< dimensionless
  Real stiffness[6];            ///< K, xx xy xz yy yz zz [N/m]
  const int32_t* center;        ///< n_centers, rows of the displacements
  const double* displacements;  ///< over R, rows of 3; of the model
  /// n_centers x 3 [N], as floats if all of them are exact in float, else as doubles; the other pointer is null.
  const float* short_coefficient;
  const double* coefficient;
  Real total[3];                          ///< sum_i b_i, see set_rest
  Real force_at_rest[3], energy_at_rest;  ///< added so that both vanish at d = 0 [N], [J / R]
};

/// Calls add(x - c, b) for every center, including the one at 0.
template <class Real, class Add>
void for_each_center(const Conservative<Real>& net, const Real* x, Add add) {
  const auto walk = [&](const auto* coefficient) {
    for (int32_t i = 0; i < net.n_centers; ++i) {
      const double* c = net.displacements + 3 * static_cast<size_t>(net.center[i]);
      const auto* b = coefficient + 3 * static_cast<size_t>(i);
      const Real y[3] = {x[0] - static_cast<Real>(c[0]), x[1] - static_cast<Real>(c[1]),
                         x[2] - static_cast<Real>(c[2])};
      const Real weight[3] = {static_cast<Real>(b[0]), static_cast<Real>(b[1]), static_cast<Real>(b[2])};
      add(y, weight);
    }
  };
  if (net.short_coefficient) {
    walk(net.short_coefficient);
  } else {
    walk(net.coefficient);
  }
  const Real weight[3] = {-net.total[0], -net.total[1], -net.total[2]};
  add(x, weight);
}

template <class Real>
Real dot(const Real* a, const Real* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// K d, with K given as xx xy xz yy yz zz.
template <class Real>
void multiply_symmetric(const Real* k, const Real* d, Real* product) {
  product[0] = k[0] * d[0] + k[1] * d[1] + k[2] * d[2];
  product[1] = k[1] * d[0] + k[3] * d[1] + k[4] * d[2];
  product[2] = k[2] * d[0] + k[4] * d[1] + k[5] * d[2];
}

/// @param net    Conservative or a type with the same constants and an overload of for_each_center
/// @param x      d / R, 3
/// @param force  3 [N]
template <class Net, class Real>
void conservative_force(const Net& net, const Real* x, Real* force) {
  const Real s2 = net.shape * net.shape;
  Real sum[3] = {0, 0, 0};
  for_each_center(net, x, [&](const Real* y, const Real* b) {
    const Real q = square_root(dot(y, y) + s2), along = dot(y, b) / q;
    for (int k = 0; k < 3; ++k) sum[k] += q * b[k] + along * y[k];
  });
  const Real d[3] = {net.max_displacement * x[0], net.max_displacement * x[1], net.max_displacement * x[2]};
  multiply_symmetric(net.stiffness, d, force);
  for (int k = 0; k < 3; ++k) force[k] += sum[k] + net.force_at_rest[k];
}

/// @return the work from rest to x [J]
template <class Net, class Real>
Real conservative_energy(const Net& net, const Real* x) {
  const Real s2 = net.shape * net.shape;
  Real sum = 0;
  for_each_center(net, x, [&](const Real* y, const Real* b) { sum += square_root(dot(y, y) + s2) * dot(y, b); });
  const Real d[3] = {net.max_displacement * x[0], net.max_displacement * x[1], net.max_displacement * x[2]};
  Real kd[3];
  multiply_symmetric(net.stiffness, d, kd);
  return dot(d, kd) / 2 + net.max_displacement * ((sum + net.energy_at_rest) + dot(net.force_at_rest, x));
}

/// @param stiffness  3 x 3 [N/m], bitwise symmetric
template <class Net, class Real>
void conservative_stiffness(const Net& net, const Real* x, Real* stiffness) {
  const Real s2 = net.shape * net.shape;
  Real sum[3][3] = {};
  for_each_center(net, x, [&](const Real* y, const Real* b) {
    const Real q = square_root(dot(y, y) + s2), n[3] = {y[0] / q, y[1] / q, y[2] / q}, along = dot(n, b);
    for (int i = 0; i < 3; ++i) {
      for (int j = i; j < 3; ++j)
        sum[i][j] += b[i] * n[j] + n[i] * b[j] + along * (static_cast<Real>(i == j) - n[i] * n[j]);
    }
  });
  const Real* k = net.stiffness;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) stiffness[3 * i + j] = stiffness[3 * j + i] = *k++ + sum[i][j] / net.max_displacement;
  }
}

/// Sets total, force_at_rest and energy_at_rest. @pre all other members of net are set
/// @param sum_force  function like conservative_force that later evaluates the force: its order of summation determines
///                   the last bits
template <class Real, class Force>
void set_rest(Conservative<Real>& net, Force sum_force) {
  const Real rest[3] = {0, 0, 0};
  Real total[3] = {0, 0, 0}, force[3];
  for (int k = 0; k < 3; ++k) net.total[k] = net.force_at_rest[k] = 0;
  net.energy_at_rest = 0;
  for_each_center(net, rest, [&](const Real*, const Real* b) {
    for (int k = 0; k < 3; ++k) total[k] += b[k];
  });
  // The functions that later add these values also compute them, so that the results at rest are exactly 0.
  Conservative<Real> unit = net;
  unit.max_displacement = 1;
  for (int k = 0; k < 3; ++k) unit.total[k] = net.total[k] = total[k];
  sum_force(unit, rest, force);
  net.energy_at_rest = -conservative_energy(unit, rest);
  for (int k = 0; k < 3; ++k) net.force_at_rest[k] = -force[k];
}

template <class Real>
void set_rest(Conservative<Real>& net) {
  set_rest(net, conservative_force<Conservative<Real>, Real>);
}

}  // namespace PHN_RUNTIME
