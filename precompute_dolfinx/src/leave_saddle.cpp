// Leaves an unstable equilibrium in a reproducible direction.
#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium.hpp"
#include "negative_curvature.hpp"

namespace phynness {
namespace {

double size_of(const Discretization& body) {
  return (body.points().colwise().maxCoeff() - body.points().colwise().minCoeff()).norm();
}

/// A force on every free displacement that has no symmetry of any body. It is a smooth function of position, so that
/// the direction of buckling depends neither on the numbering of the nodes nor on rounding.
Eigen::VectorXd generic_force(const Discretization& body, const TangentMatrix& tangent, const Constraint& constraint,
                              const std::vector<char>& is_free) {
  std::vector<double> nodal(static_cast<std::size_t>(body.n_dofs()), 0.0);
  const Eigen::RowVector3d wave = Eigen::RowVector3d(3.1, 1.7, 2.3) / size_of(body);
  const Eigen::RowVector3d corner = body.points().colwise().minCoeff();
  for (int p = 0; p < body.n_points(); ++p)
    for (int k = 0; k < 3; ++k)
      if (const auto dof = body.dofs(p)[k]; dof >= 0)
        nodal[dof] = std::sin(wave.dot(body.points().row(p) - corner) + 1 + 0.7 * k);
  constraint.condense(nodal);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(tangent.n_unknowns());
  for (int i = 0; i < tangent.n_unknowns(); ++i)
    if (const auto dof = tangent.dof_of()[i]; is_free[dof]) force[i] = nodal[dof];
  return force;
}

}  // namespace

bool Equilibrium::break_symmetry(Vec step) {
  constexpr double share = 1e-6;
  const auto force = generic_force(_body, _tangent, _constraint, _is_free);
  PetscVec b, z;
  PHYNNESS_PETSC(VecDuplicate(step, b.address()));
  PHYNNESS_PETSC(VecDuplicate(step, z.address()));
  WriteValues(b).map() = force;
  if (!_linear->solve(b, z)) return false;
  ++_counts.substitutions;
  PetscReal of_step = 0, of_z = 0;
  PHYNNESS_PETSC(VecNorm(step, NORM_INFINITY, &of_step));
  PHYNNESS_PETSC(VecNorm(z, NORM_INFINITY, &of_z));
  if (of_z > 0) PHYNNESS_PETSC(VecAXPY(step, share * of_step / of_z, z));
  return true;
}

bool Equilibrium::leave_saddle() {
  const auto saddle = _state;
  const double size = size_of(_body);
  _tangent.assemble(_body, _state, Convexity::strictly);
  ++_counts.tangents;
  _factors_are_convex = true;
  _quasi_newton.clear();
  _pressures.set(_tangent.matrix());
  if (!factorize() || (!_pressures.empty() && !_pressures.is_definite())) return false;
  const auto found =
      most_negative_curvature(*_linear, _tangent.exact(), generic_force(_body, _tangent, _constraint, _is_free));
  if (found.direction.size() == 0) return false;

  double largest = 0;
  for (int p = 0; p < _body.n_points(); ++p)
    for (const auto dof : _body.dofs(p))
      if (dof >= 0 && _is_free[dof]) largest = std::max(largest, std::abs(found.direction[_tangent.unknown_of()[dof]]));
  if (!(largest > 0)) return false;
  const auto merit_at = [&](double length) {
    _state = saddle;
    for (int i = 0; i < _tangent.n_unknowns(); ++i)
      _state[_tangent.dof_of()[i]] += length / largest * found.direction[i];
    _constraint.complete(_state, _held);
    evaluate_residual();
    const bool valid = std::isfinite(free_norm()) && (!_body.forms().checks_jacobian || _body.min_jacobian(_state) > 0);
    return valid ? merit() : std::numeric_limits<double>::infinity();
  };
  // Lengths in units of the body: from far above rounding to visible bending.
  constexpr double shortest = 1e-5, longest = 0.1;
  const double at_saddle = merit_at(0);
  double best = 0, lowest = at_saddle;
  if (!std::isfinite(at_saddle)) return false;
  for (const double sign : {1.0, -1.0}) {
    double here = 0, before = at_saddle;
    for (double length = shortest * size; length <= longest * size; length *= 2) {
      const double now = merit_at(sign * length);
      if (!(now < before)) {
        // The decrease of the energy in the first steps may be below rounding.
        if (length > 1e-3 * size || !std::isfinite(now)) break;
        continue;
      }
      before = now;
      here = sign * length;
    }
    // The opposite direction is taken only if its energy is lower by more than rounding, so that a symmetric body
    // always takes the first direction.
    if (before < lowest - (sign < 0 ? 1e-3 * (at_saddle - lowest) : 0)) {
      lowest = before;
      best = here;
    }
  }
  merit_at(best);
  // The threshold is several hundred times the rounding error of the energy.
  return at_saddle - lowest > 1e-13 * std::abs(at_saddle);
}

}  // namespace phynness
