// The line search along the direction of SNES, and the decision whether the next step needs a new tangent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium.hpp"
#include "factorization.hpp"
#include "petsc_check.hpp"

namespace phynness {
namespace {

// The factor by which a step with old factors must reduce the residual; otherwise a new tangent is more efficient.
constexpr double required_reduction = 0.5;
// The cost of assembly and factorization in steps with old factors (Case 3: P1 6, p1-p1 7, quadratic elements 10).
constexpr double tangent_cost_in_steps = 7;
// A full step from a stable state that reduces the residual by this factor is accepted without the merit function,
// which would require the factors of the pressure block.
constexpr double quick_reduction = 0.1;
// The usual constant of Armijo's rule.
constexpr double armijo_constant = 1e-4;

/// The result of newton_cg().
struct NewtonCg {
  int iterations = 0;
  bool negative_curvature = false;
  bool failed = false;  ///< the preconditioner gave no finite result; the step is undefined
};

/// Solves K y = f with a relative accuracy of 0.1 in the preconditioner's norm, or until a direction of negative
/// curvature is found. The step along this direction has the length that it would have with the opposite curvature
/// (Steihaug 1983, doi:10.1137/0720042; length as in modified Newton methods).
/// @param preconditioner  applies the inverse of a positive definite approximation of K
/// @param y  on entry the preconditioner applied to f, on return the step; f . y > 0
NewtonCg newton_cg(Factorization& preconditioner, Mat K, Vec f, Vec y) {
  constexpr int most_iterations = 40;
  constexpr double reduction = 0.1;
  PetscVec r, z, p, q;
  for (auto* vector : {&r, &z, &p, &q}) PHYNNESS_PETSC(VecDuplicate(f, vector->address()));
  PHYNNESS_PETSC(VecCopy(f, r));
  PHYNNESS_PETSC(VecCopy(y, z));
  PHYNNESS_PETSC(VecCopy(y, p));
  PHYNNESS_PETSC(VecSet(y, 0));

  NewtonCg out;
  double rz = dot(r, z);
  double p_squared = rz;  // p M p with the preconditioner's matrix M
  const double residual_tolerance = reduction * reduction * rz;
  while (out.iterations < most_iterations) {
    ++out.iterations;
    PHYNNESS_PETSC(MatMult(K, p, q));
    const double curvature = dot(p, q);
    out.negative_curvature = !(curvature > 0);
    PHYNNESS_PETSC(VecAXPY(y, rz / (out.negative_curvature ? p_squared : curvature), p));
    if (out.negative_curvature) break;
    PHYNNESS_PETSC(VecAXPY(r, -rz / curvature, q));
    if (!preconditioner.solve(r, z)) {
      out.failed = true;
      break;
    }
    const double next_rz = dot(r, z);
    if (!(next_rz > residual_tolerance)) break;
    PHYNNESS_PETSC(VecAYPX(p, next_rz / rz, z));
    p_squared = next_rz + (next_rz / rz) * (next_rz / rz) * p_squared;
    rz = next_rz;
  }
  return out;
}

}  // namespace

/// The step x <- x - length * y.
class Equilibrium::Step {
 public:
  Step(Equilibrium& solver, SNESLineSearch search) : _solver(solver), _search(search) {
    PHYNNESS_PETSC(SNESLineSearchGetVecs(search, &_x, &_f, &_y, &_trial, &_trial_f));
    _norm_before = norm(_f);
  }

  void take() {
    const double reactions = _solver._reaction_norm;
    const double length = _solver._factors_are_current ? newton_step() : quasi_newton_step();
    if (length < 0) {
      PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_FAILED_REDUCT));
      return;
    }
    if (length > 0) {
      PHYNNESS_PETSC(VecCopy(_trial, _x));
      PHYNNESS_PETSC(VecCopy(_trial_f, _f));
      _solver._quasi_newton.record_step(_y, length);
    } else if (!_pressures_changed) {
      _norm_after = _norm_before;
      _solver._reaction_norm = reactions;
    }
    PHYNNESS_PETSC(SNESLineSearchSetNorms(_search, norm(_x), _norm_after, norm(_y)));
    PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_SUCCEEDED));
  }

 private:
  /// A full quasi-Newton step with old factors. This and the following functions return the length of the step: 0
  /// requests a new tangent, and a negative value fails the solve.
  double quasi_newton_step() {
    _solver._quasi_newton.correct(_y);
    const bool finite = evaluate_at(1);
    _solver._needs_tangent = !finite || _norm_after > required_reduction * _norm_before || needs_tangent();
    return finite && _norm_after < _norm_before ? 1 : 0;
  }

  double newton_step() {
    // With an indefinite tangent Newton's method may converge to a saddle point.
    if (!_solver._convex && _solver.negative_pivots() > 0) {
      _solver._met_instability = true;
      return request_convex_tangent();
    }
    bool negative_curvature = false;
    if (_solver._convex && !_solver._needs_strict_convexity && _solver.negative_pivots() > 0) {
      _solver._needs_strict_convexity = _solver._needs_tangent = true;
      return 0;
    }
    if (_solver._convex) {
      const auto cg = newton_cg(_solver._factorization, _solver._tangent.exact(), _f, _y);
      _solver._counts.substitutions += cg.iterations;
      negative_curvature = cg.negative_curvature;
      if (cg.failed || (_solver._met_instability && !_solver.break_symmetry(_y))) {
        _solver._factorization_failed = true;
        return -1;
      }
    }
    const bool is_stable = !_solver._convex && !_solver._met_instability && !_solver._pressures.empty();
    if (is_stable && evaluate_at(1) && _norm_after <= quick_reduction * _norm_before) {
      _solver._needs_tangent = needs_tangent();
      return 1;
    }
    find_pressure_correction();
    // The negative derivative of the merit function along the step, whose pressures aim at r_p = 0.
    const double slope = dot(_f, _y) + 2 * _pressure_energy;
    // Without a definite pressure block the merit function is not defined, and the norm of the residual is used.
    _merit_is_defined = _solver._pressures.empty() || _solver._pressures.is_definite();
    if (_merit_is_defined && !(slope > 0)) return _solver._convex ? -1 : request_convex_tangent();

    double low = 0, high = std::numeric_limits<double>::infinity(), low_slope = slope, length = 1;
    for (int trial = 0; trial < 20; ++trial) {
      const bool finite = evaluate_at(length);
      const double trial_slope = finite ? trial_merit_slope() : 0;
      if (finite && is_acceptable(length, slope, trial_slope)) {
        // With negative curvature at the start, a slope of more than half of the initial one means that the minimum is
        // farther away.
        if (negative_curvature && trial_slope > 0.5 * slope && length < 100 && !std::isfinite(high)) {
          low = length;
          low_slope = trial_slope;
          length *= 2;
          continue;
        }
        if (negative_curvature) equilibrate_pressures(_trial, _trial_f);
        _solver._needs_tangent = _solver._convex || needs_tangent();
        _solver._convex = negative_curvature;
        return length;
      }
      high = length;
      // If the slope has changed its sign, the secant gives its zero.
      const double fraction = trial_slope < 0 ? std::clamp(low_slope / (low_slope - trial_slope), 0.1, 0.7) : 0.5;
      length = low + fraction * (high - low);
    }
    // Longer steps were worse, so that the longest acceptable one is used.
    if (low > 0 && evaluate_at(low)) {
      equilibrate_pressures(_trial, _trial_f);
      _solver._needs_tangent = true;
      return low;
    }
    return !_solver._convex ? request_convex_tangent() : -1;
  }

  /// Requests a convex tangent without a step. Conjugate gradients require equilibrated pressures.
  double request_convex_tangent() {
    equilibrate_pressures(_x, _f);
    _solver._convex = _solver._needs_tangent = true;
    return 0;
  }

  /// Iterates p <- p + C^-1 r_p until the change is negligible or the residual no longer decreases.
  void equilibrate_pressures(Vec x, Vec f) {
    if (_solver._pressures.empty()) return;
    _solver.set_state(x);
    double energy = std::numeric_limits<double>::infinity(), first_energy = 0;
    auto best = _solver._state;
    for (int i = 0; i < 8; ++i) {
      _solver.evaluate_residual();
      _solver.copy_residual(f);
      const auto r_p = _solver._pressures.pressures_of(f);
      const Eigen::VectorXd change = _solver._pressures.solve(r_p);
      const double next_energy = r_p.dot(change);
      if (!(next_energy < energy)) break;
      if (i == 0) first_energy = next_energy;
      energy = next_energy;
      best = _solver._state;
      if (energy <= 1e-8 * first_energy) break;
      const auto& dofs = _solver._body.pressure_dofs();
      for (std::size_t k = 0; k < dofs.size(); ++k) _solver._state[dofs[k]] += change[static_cast<Eigen::Index>(k)];
    }
    _solver._state = best;
    _solver.evaluate_residual();
    _solver.copy_unknowns(x);
    _solver.copy_residual(f);
    _norm_after = _solver.free_residual_norm();
    _pressures_changed = true;
  }

  /// Computes the correction of the pressures at the start of the step, and its energy.
  void find_pressure_correction() {
    if (_solver._pressures.empty()) return;
    const auto r_p = _solver._pressures.pressures_of(_f);
    _pressure_correction = _solver._pressures.solve(r_p);
    _pressure_energy = r_p.dot(_pressure_correction) / 2;
  }

  /// The negative derivative of the merit function along the step at the trial point.
  double trial_merit_slope() const {
    const double slope = dot(_trial_f, _y);
    return _solver._pressures.empty() ? slope
                                      : slope + _solver._pressures.pressures_of(_trial_f).dot(_pressure_correction);
  }

  /// @return false if the residual at the trial point is not finite (J <= 0 in a law with ln J)
  bool evaluate_at(double length) {
    PHYNNESS_PETSC(VecWAXPY(_trial, -length, _y, _x));
    _solver.set_state(_trial);
    _solver.evaluate_residual();
    _norm_after = _solver.free_residual_norm();
    _solver.copy_residual(_trial_f);
    return std::isfinite(_norm_after);
  }

  bool is_acceptable(double length, double slope, double trial_slope) {
    const bool is_reduced = _norm_after <= (1 - armijo_constant * length) * _norm_before;
    // The step mainly changes the pressures, on which the merit function does not depend.
    if (!_merit_is_defined || _pressure_energy > slope) return is_reduced;
    if (std::abs(trial_slope) <= 0.5 * slope) return true;
    const double after = _solver.merit();
    if (std::isnan(_merit_before)) {
      const auto trial_state = _solver._state;
      _solver.set_state(_x);
      _merit_before = _solver._body.energy(_solver._state) + _pressure_energy;
      _solver._state = trial_state;
    }
    // If the change of the energy is below rounding, the residual decides.
    if (slope * length < 1e-9 * std::abs(_merit_before)) return is_reduced;
    return after <= _merit_before - armijo_constant * length * slope;
  }

  /// Whether steps with old factors, at the rate of this one, would cost more in total than a new tangent.
  bool needs_tangent() const {
    const double residual_tolerance = _solver.residual_tolerance(), rate = _norm_after / _norm_before;
    if (!(_norm_after > residual_tolerance)) return false;
    return std::log(residual_tolerance / _norm_after) / std::log(std::min(rate, 0.99)) > tangent_cost_in_steps;
  }

  Equilibrium& _solver;
  SNESLineSearch _search;
  Vec _x = nullptr, _f = nullptr, _y = nullptr, _trial = nullptr, _trial_f = nullptr;
  double _norm_before = 0, _norm_after = 0, _merit_before = std::numeric_limits<double>::quiet_NaN();
  bool _merit_is_defined = true;
  bool _pressures_changed = false;       ///< equilibrate_pressures() has changed x
  double _pressure_energy = 0;           ///< r_p^T C^-1 r_p / 2
  Eigen::VectorXd _pressure_correction;  ///< C^-1 r_p
};

PetscErrorCode Equilibrium::step(SNESLineSearch search, void* context) {
  auto& self = *static_cast<Equilibrium*>(context);
  return self.catch_exceptions([&] { Step(self, search).take(); });
}

}  // namespace phynness
