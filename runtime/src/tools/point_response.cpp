#include "tools/point_response.hpp"

#include <cmath>

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Gauss-Legendre quadrature on 0 ... 1, exact for polynomials of degree 5.
constexpr double gauss_point[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weight[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};

}  // namespace

double PointResponses::respond(std::int32_t s, const Vector& p) {
  Constraint& point = _c.point[s];
  point.own = p;
  take_response(s);
  pull(s);
  return point.energy + energy_of_nodes(point);
}

void PointResponses::take_response(std::int32_t s) {
  Constraint& point = _c.point[s];
  Vector r = point.own;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const std::int32_t n = basis_size(_model, node(point, i));
    const Vector q = point.contribution[i] * point.own, e = point.reach[i] * point.own;
    const double square = dot(e, e), share = square > 0 ? dot(q, e) / square : 0;
    const Vector left = q - share * e;
    basis_of(_model, node(point, i), e.x, _c.basis, _c.kernel);
    const double* gradient = gradient_at_rest(s, i);
    double* basis = response_basis(s, i);
    for (std::int32_t j = 0; j < n; ++j)
      basis[j] =
          share * _c.basis[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
    point.response_share[i] = share;
    point.response_own[i] = q;
    r -= displacement_of(_c.displacement[at(s, s, i)], share, q, n, basis);
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    move_at_rest(s, i, r, 1, response_basis(s, i), point.response_own[i]);
}

Vector PointResponses::displaced(std::int32_t t, std::int32_t s) const {
  const Constraint& point = _c.point[s];
  Vector u = {};
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    u += displacement_of(_c.displacement[at(t, s, i)], point.response_share[i], point.response_own[i],
                         basis_size(_model, node(point, i)), response_basis(s, i));
  return u;
}

void PointResponses::add_derivatives(std::int32_t t, std::int32_t i) {
  const Constraint& point = _c.point[t];
  const ActiveNode& by = node(point, i);
  const std::int32_t n = basis_size(_model, by);
  const Matrix &to_q = point.contribution[i], &to_e = point.reach[i];
  const Vector q = to_q * point.own, e = to_e * point.own;
  const double square = dot(e, e), share = point.response_share[i];
  // d(share)/dp for share = q . e / e . e
  Vector by_share = {};
  if (square > 0)
    by_share =
        (transposed_times(to_q, e) + transposed_times(to_e, q) - (2 * share) * transposed_times(to_e, e)) / square;
  const Matrix left = to_q - share * to_e - outer(e, by_share);
  basis_and_gradient(_model, by, e.x, _c.basis, _c.gradient, _c.kernel);
  for (std::int32_t s = 0; s < n_places(); ++s) {
    const NodeField& local = _c.displacement[at(place(s), t, i)];
    Matrix change = {};
    Vector value = local.constant;
    for (int r = 0; r < 3; ++r) {
      for (std::int32_t j = 0; j < n; ++j) {
        const double weight = local.rows[r * n + j];
        value[r] += weight * _c.basis[j];
        for (int k = 0; k < 3; ++k) change(r, k) += weight * _c.gradient[k * n + j];
      }
    }
    Matrix& sum = _c.derivative[at(place(s), t)];
    sum += share * (change * to_e) + outer(value, by_share);
    sum += local.direct * to_q;
    sum += (_c.rest_response[at(place(s), t, i)] - local.direct) * left;
  }
}

void PointResponses::find_derivatives(std::int32_t t) {
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] = {};
  for (std::int32_t i = 0; i < _c.point[t].n_nodes; ++i) add_derivatives(t, i);
  // The remaining displacement of the tool's point is added as in the undeformed body.
  const Matrix lacks = diagonal(1) - _c.derivative[at(t, t)];
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] += rest_block(s, t) * lacks;
}

double PointResponses::energy_of_nodes(const Constraint& point) const {
  double energy = 0;
  for (std::int32_t i = 0; i < point.n_nodes && _model.has_energy; ++i) {
    Vector force;
    double one = 0;
    evaluate_force(_model, node(point, i), (point.reach[i] * point.own).x, force.x, &one, nullptr);
    energy += point.share[i] * one;
  }
  return energy;
}

void PointResponses::pull(std::int32_t s) {
  Constraint& point = _c.point[s];
  const Vector linear = point.stiffness * point.own;
  double energy = dot(linear, point.own) / 2;
  point.force = linear;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const Vector e = point.reach[i] * point.own, ke = point.rest_stiffness[i] * e;
    Vector f;
    evaluate_force(_model, node(point, i), e.x, f.x);
    point.force += point.share[i] * transposed_times(point.reach[i], f - ke);
    energy -= point.share[i] * dot(ke, e) / 2;
    // A single node follows the tool exactly, so that psi is 0.
    for (int g = 0; g < 3 && point.n_nodes > 1; ++g)
      energy -= pull_of_coupling(s, i, e, linear, gauss_point[g], gauss_weight[g]);
  }
  point.energy = energy;
}

double PointResponses::pull_of_coupling(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x,
                                        double w) {
  Constraint& point = _c.point[s];
  const ActiveNode& by = node(point, i);
  const NodeField& local = _c.displacement[at(s, s, i)];
  const double* rest_gradient = gradient_at_rest(s, i);
  const std::int32_t n = basis_size(_model, by);
  const Vector there = x * e;
  basis_and_gradient(_model, by, there.x, _c.basis, _c.gradient, _c.kernel);
  const Vector z = displacement_of(local, 1, there, n, _c.basis) - _c.rest_response[at(s, s, i)] * there;
  // (dz/de)^T A p
  Vector back = {};
  for (int r = 0; r < 3; ++r) {
    const double* row = local.rows + r * n;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::int32_t j = 0; j < n; ++j) sum += row[j] * (_c.gradient[k * n + j] - rest_gradient[k * n + j]);
      back[k] += x * linear[r] * sum;
    }
  }
  point.force -= (w * point.share[i]) * (point.stiffness * z + transposed_times(point.reach[i], back));
  return w * point.share[i] * dot(linear, z);
}

}  // namespace PHN_RUNTIME
