// Length of the step along the direction computed by SNES, and the decision whether the next step needs a new tangent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium.hpp"
#include "factorization.hpp"
#include "petsc_check.hpp"

namespace phynness {
namespace {

// A step with old factors must at least halve the residual; otherwise a new tangent, which costs as much as several
// such steps, reduces it faster.
constexpr double cheap_step_worth = 0.5;
// Assembly and factorization of a tangent cost about as much as seven steps with old factors (Case 3: P1 6, p1-p1 7,
// quadratic elements 10).
constexpr double price_of_a_tangent = 7;
// A full step that reduces the residual by this factor, from a stable state in a solve without instability, is accepted
// without the merit function, for which the pressure block would be factorized.
constexpr double good_newton_step = 0.1;
// The usual constant of Armijo's rule, which accepts any significant decrease.
constexpr double decrease = 1e-4;

/// A Newton step with an indefinite tangent, by conjugate gradients that detect negative curvature.
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
  const double goal = reduction * reduction * rz;
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
    const double next = dot(r, z);
    if (!(next > goal)) break;
    PHYNNESS_PETSC(VecAYPX(p, next / rz, z));
    p_squared = next + (next / rz) * (next / rz) * p_squared;
    rz = next;
  }
  return out;
}

}  // namespace

/// The step x <- x - length * y.
class Equilibrium::Step {
 public:
  Step(Equilibrium& solver, SNESLineSearch search) : _solver(solver), _search(search) {
    PHYNNESS_PETSC(SNESLineSearchGetVecs(search, &_x, &_f, &_y, &_trial, &_trial_f));
    _before = norm(_f);
  }

  void take() {
    const double reactions = _solver._reaction_norm;
    const double length = _solver._fresh ? newton() : cheap();
    if (length < 0) {
      PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_FAILED_REDUCT));
      return;
    }
    if (length > 0) {
      PHYNNESS_PETSC(VecCopy(_trial, _x));
      PHYNNESS_PETSC(VecCopy(_trial_f, _f));
      _solver._quasi_newton.remember(_y, length);
    } else if (!_settled) {
      _after = _before;
      _solver._reaction_norm = reactions;
    }
    PHYNNESS_PETSC(SNESLineSearchSetNorms(_search, norm(_x), _after, norm(_y)));
    PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_SUCCEEDED));
  }

 private:
  /// A full step, or none, with old factors that are corrected by the steps since (quasi-Newton).
  /// This and the following functions return the length; 0: stay and compute a new tangent; negative: the solve fails.
  double cheap() {
    _solver._quasi_newton.correct(_y);
    const bool finite = try_length(1);
    _solver._refresh = !finite || _after > cheap_step_worth * _before || wants_tangent();
    return finite && _after < _before ? 1 : 0;
  }

  double newton() {
    // Newton's method would converge to a saddle point.
    if (!_solver._convex && _solver.negative_pivots() > 0) {
      _solver._met_instability = true;
      return make_convex();
    }
    bool negative_curvature = false;
    if (_solver._convex && !_solver._strictly && _solver.negative_pivots() > 0) {
      _solver._strictly = _solver._refresh = true;
      return 0;
    }
    if (_solver._convex) {
      const auto cg = newton_cg(_solver._linear, _solver._tangent.exact(), _f, _y);
      _solver._counts.substitutions += cg.iterations;
      negative_curvature = cg.negative_curvature;
      if (cg.failed || (_solver._met_instability && !_solver.break_symmetry(_y))) {
        _solver._linear_failed = true;
        return -1;
      }
    }
    const bool calm = !_solver._convex && !_solver._met_instability && !_solver._pressures.empty();
    if (calm && try_length(1) && _after <= good_newton_step * _before) {
      _solver._refresh = wants_tangent();
      return 1;
    }
    look_at_pressures();
    // The negative derivative of the merit function along the step, whose pressures aim at r_p = 0.
    const double slope = dot(_f, _y) + 2 * _gap_before;
    // Without a definite pressure block the merit function is not defined, and the norm of the residual is used.
    _has_merit = _solver._pressures.empty() || _solver._pressures.is_definite();
    if (_has_merit && !(slope > 0)) return _solver._convex ? -1 : make_convex();

    double low = 0, high = std::numeric_limits<double>::infinity(), low_slope = slope, length = 1;
    for (int trial = 0; trial < 20; ++trial) {
      const bool finite = try_length(length);
      const double here = finite ? slope_of_trial() : 0;
      if (finite && good_enough(length, slope, here)) {
        // With negative curvature at the start, a slope of more than half of the initial one means that the minimum is
        // farther away.
        if (negative_curvature && here > 0.5 * slope && length < 100 && !std::isfinite(high)) {
          low = length;
          low_slope = here;
          length *= 2;
          continue;
        }
        if (negative_curvature) settle_pressures(_trial, _trial_f);
        _solver._refresh = _solver._convex || wants_tangent();
        _solver._convex = negative_curvature;
        return length;
      }
      high = length;
      // If the slope has changed its sign, the secant gives its zero.
      const double fraction = here < 0 ? std::clamp(low_slope / (low_slope - here), 0.1, 0.7) : 0.5;
      length = low + fraction * (high - low);
    }
    // Longer steps were worse; take the longest good one.
    if (low > 0 && try_length(low)) {
      settle_pressures(_trial, _trial_f);
      _solver._refresh = true;
      return low;
    }
    return !_solver._convex ? make_convex() : -1;
  }

  /// Makes no step and requests a convex tangent; conjugate gradients then need pressures in equilibrium.
  double make_convex() {
    settle_pressures(_x, _f);
    _solver._convex = _solver._refresh = true;
    return 0;
  }

  /// Iterates p <- p + C^-1 r_p until the change is negligible or the residual no longer decreases.
  void settle_pressures(Vec x, Vec f) {
    if (_solver._pressures.empty()) return;
    _solver.gather(x);
    double gap = std::numeric_limits<double>::infinity(), first = 0;
    auto best = _solver._state;
    for (int i = 0; i < 8; ++i) {
      _solver.evaluate_residual();
      _solver.scatter(f);
      const auto r_p = _solver._pressures.part(f);
      const Eigen::VectorXd change = _solver._pressures.solve(r_p);
      const double now = r_p.dot(change);
      if (!(now < gap)) break;
      if (i == 0) first = now;
      gap = now;
      best = _solver._state;
      if (gap <= 1e-8 * first) break;
      const auto& dofs = _solver._body.pressure_dofs();
      for (std::size_t k = 0; k < dofs.size(); ++k) _solver._state[dofs[k]] += change[static_cast<Eigen::Index>(k)];
    }
    _solver._state = best;
    _solver.evaluate_residual();
    _solver.spread(x);
    _solver.scatter(f);
    _after = _solver.free_norm();
    _settled = true;
  }

  /// Distance of the pressures from their equilibrium at the start of the step.
  void look_at_pressures() {
    if (_solver._pressures.empty()) return;
    const auto r_p = _solver._pressures.part(_f);
    _pressure_change = _solver._pressures.solve(r_p);
    _gap_before = r_p.dot(_pressure_change) / 2;
  }

  /// The negative derivative of the merit function along the step at the trial point.
  double slope_of_trial() const {
    const double slope = dot(_trial_f, _y);
    return _solver._pressures.empty() ? slope : slope + _solver._pressures.part(_trial_f).dot(_pressure_change);
  }

  /// @return false if the residual at the trial point is not finite (J <= 0 in a law with ln J)
  bool try_length(double length) {
    PHYNNESS_PETSC(VecWAXPY(_trial, -length, _y, _x));
    _solver.gather(_trial);
    _solver.evaluate_residual();
    _after = _solver.free_norm();
    _solver.scatter(_trial_f);
    return std::isfinite(_after);
  }

  bool good_enough(double length, double slope, double here) {
    const bool shorter = _after <= (1 - decrease * length) * _before;
    // The step mainly changes the pressures, which are already in equilibrium in the merit function.
    if (!_has_merit || _gap_before > slope) return shorter;
    if (std::abs(here) <= 0.5 * slope) return true;
    const double after = _solver.merit();
    if (std::isnan(_merit_before)) {
      const auto moved = _solver._state;
      _solver.gather(_x);
      _merit_before = _solver.energy_and_load() + _gap_before;
      _solver._state = moved;
    }
    // If the change of the energy is below rounding, the residual decides.
    if (slope * length < 1e-9 * std::abs(_merit_before)) return shorter;
    return after <= _merit_before - decrease * length * slope;
  }

  /// Whether steps with old factors, at the rate of this one, would cost more in total than a new tangent.
  bool wants_tangent() const {
    const double goal = _solver.goal(), rate = _after / _before;
    if (!(_after > goal)) return false;
    return std::log(goal / _after) / std::log(std::min(rate, 0.99)) > price_of_a_tangent;
  }

  Equilibrium& _solver;
  SNESLineSearch _search;
  Vec _x = nullptr, _f = nullptr, _y = nullptr, _trial = nullptr, _trial_f = nullptr;
  double _before = 0, _after = 0, _merit_before = std::numeric_limits<double>::quiet_NaN();
  bool _has_merit = true;
  bool _settled = false;             ///< pressures, and therefore x, have been changed
  double _gap_before = 0;            ///< r_p^T C^-1 r_p / 2
  Eigen::VectorXd _pressure_change;  ///< C^-1 r_p
};

PetscErrorCode Equilibrium::step(SNESLineSearch search, void* context) {
  auto& self = *static_cast<Equilibrium*>(context);
  return self.contain([&] { Step(self, search).take(); });
}

}  // namespace phynness
