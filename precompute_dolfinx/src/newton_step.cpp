// Length of the step along the direction computed by SNES, and the decision whether the next step needs a new tangent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium_impl.hpp"
#include "newton_cg.hpp"

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

/// The step x <- x - length * y. (The functions are templates because Impl is private to Equilibrium.)
class Step {
 public:
  explicit Step(SNESLineSearch search) : _search(search) {
    PHYNNESS_PETSC(SNESLineSearchGetVecs(search, &_x, &_f, &_y, &_trial, &_trial_f));
    _before = norm(_f);
  }

  template <typename Impl>
  void take(Impl& s) {
    const double reactions = s.reaction_norm;
    const double length = s.fresh ? newton(s) : cheap(s);
    if (length < 0) {
      PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_FAILED_REDUCT));
      return;
    }
    if (length > 0) {
      PHYNNESS_PETSC(VecCopy(_trial, _x));
      PHYNNESS_PETSC(VecCopy(_trial_f, _f));
      s.quasi_newton.remember(_y, length);
    } else if (!_settled) {
      _after = _before;
      s.reaction_norm = reactions;
    }
    PHYNNESS_PETSC(SNESLineSearchSetNorms(_search, norm(_x), _after, norm(_y)));
    PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_SUCCEEDED));
  }

 private:
  /// A full step, or none, with old factors that are corrected by the steps since (quasi-Newton).
  /// This and the following functions return the length; 0: stay and compute a new tangent; negative: the solve fails.
  template <typename Impl>
  double cheap(Impl& s) {
    s.quasi_newton.correct(_y);
    const bool finite = try_length(s, 1);
    s.refresh = !finite || _after > cheap_step_worth * _before || wants_tangent(s);
    return finite && _after < _before ? 1 : 0;
  }

  template <typename Impl>
  double newton(Impl& s) {
    // Newton's method would converge to a saddle point.
    if (!s.convex && s.negative_pivots() > 0) {
      s.met_instability = true;
      return make_convex(s);
    }
    bool negative_curvature = false;
    if (s.convex && !s.strictly && s.negative_pivots() > 0) {
      s.strictly = s.refresh = true;
      return 0;
    }
    if (s.convex) {
      const auto cg = newton_cg(*s.linear, s.tangent.exact(), _f, _y);
      s.counts.substitutions += cg.iterations;
      negative_curvature = cg.negative_curvature;
      if (cg.failed || (s.met_instability && !s.break_symmetry(_y))) {
        s.linear_failed = true;
        return -1;
      }
    }
    const bool calm = !s.convex && !s.met_instability && !s.pressures.empty();
    if (calm && try_length(s, 1) && _after <= good_newton_step * _before) {
      s.refresh = wants_tangent(s);
      return 1;
    }
    look_at_pressures(s);
    // The negative derivative of the merit function along the step, whose pressures aim at r_p = 0.
    const double slope = dot(_f, _y) + 2 * _gap_before;
    // Without a definite pressure block the merit function is not defined, and the norm of the residual is used.
    _has_merit = s.pressures.empty() || s.pressures.is_definite();
    if (_has_merit && !(slope > 0)) return s.convex ? -1 : make_convex(s);

    double low = 0, high = std::numeric_limits<double>::infinity(), low_slope = slope, length = 1;
    for (int trial = 0; trial < 20; ++trial) {
      const bool finite = try_length(s, length);
      const double here = finite ? slope_of_trial(s) : 0;
      if (finite && good_enough(s, length, slope, here)) {
        // With negative curvature at the start, a slope of more than half of the initial one means that the minimum is
        // farther away.
        if (negative_curvature && here > 0.5 * slope && length < 100 && !std::isfinite(high)) {
          low = length;
          low_slope = here;
          length *= 2;
          continue;
        }
        if (negative_curvature) settle_pressures(s, _trial, _trial_f);
        s.refresh = s.convex || wants_tangent(s);
        s.convex = negative_curvature;
        return length;
      }
      high = length;
      // If the slope has changed its sign, the secant gives its zero.
      const double fraction = here < 0 ? std::clamp(low_slope / (low_slope - here), 0.1, 0.7) : 0.5;
      length = low + fraction * (high - low);
    }
    // Longer steps were worse; take the longest good one.
    if (low > 0 && try_length(s, low)) {
      settle_pressures(s, _trial, _trial_f);
      s.refresh = true;
      return low;
    }
    return !s.convex ? make_convex(s) : -1;
  }

  /// Makes no step and requests a convex tangent; conjugate gradients then need pressures in equilibrium.
  template <typename Impl>
  double make_convex(Impl& s) {
    settle_pressures(s, _x, _f);
    s.convex = s.refresh = true;
    return 0;
  }

  /// Iterates p <- p + C^-1 r_p until the change is negligible or the residual no longer decreases.
  template <typename Impl>
  void settle_pressures(Impl& s, Vec x, Vec f) {
    if (s.pressures.empty()) return;
    s.gather(x);
    double gap = std::numeric_limits<double>::infinity(), first = 0;
    auto best = s.state;
    for (int i = 0; i < 8; ++i) {
      s.evaluate_residual();
      s.scatter(f);
      const auto r_p = s.pressures.part(f);
      const Eigen::VectorXd change = s.pressures.solve(r_p);
      const double now = r_p.dot(change);
      if (!(now < gap)) break;
      if (i == 0) first = now;
      gap = now;
      best = s.state;
      if (gap <= 1e-8 * first) break;
      const auto& dofs = s.body.pressure_dofs();
      for (std::size_t k = 0; k < dofs.size(); ++k) s.state[dofs[k]] += change[static_cast<Eigen::Index>(k)];
    }
    s.state = best;
    s.evaluate_residual();
    s.spread(x);
    s.scatter(f);
    _after = s.free_norm();
    _settled = true;
  }

  /// Distance of the pressures from their equilibrium at the start of the step.
  template <typename Impl>
  void look_at_pressures(Impl& s) {
    if (s.pressures.empty()) return;
    const auto r_p = s.pressures.part(_f);
    _pressure_change = s.pressures.solve(r_p);
    _gap_before = r_p.dot(_pressure_change) / 2;
  }

  /// The negative derivative of the merit function along the step at the trial point.
  template <typename Impl>
  double slope_of_trial(const Impl& s) const {
    const double slope = dot(_trial_f, _y);
    return s.pressures.empty() ? slope : slope + s.pressures.part(_trial_f).dot(_pressure_change);
  }

  /// @return false if the residual at the trial point is not finite (J <= 0 in a law with ln J)
  template <typename Impl>
  bool try_length(Impl& s, double length) {
    PHYNNESS_PETSC(VecWAXPY(_trial, -length, _y, _x));
    s.gather(_trial);
    s.evaluate_residual();
    _after = s.free_norm();
    s.scatter(_trial_f);
    return std::isfinite(_after);
  }

  template <typename Impl>
  bool good_enough(Impl& s, double length, double slope, double here) {
    const bool shorter = _after <= (1 - decrease * length) * _before;
    // The step mainly changes the pressures, which are already in equilibrium in the merit function.
    if (!_has_merit || _gap_before > slope) return shorter;
    if (std::abs(here) <= 0.5 * slope) return true;
    const double after = s.merit();
    if (std::isnan(_merit_before)) {
      const auto moved = s.state;
      s.gather(_x);
      _merit_before = s.energy_and_load() + _gap_before;
      s.state = moved;
    }
    // If the change of the energy is below rounding, the residual decides.
    if (slope * length < 1e-9 * std::abs(_merit_before)) return shorter;
    return after <= _merit_before - decrease * length * slope;
  }

  /// Whether steps with old factors, at the rate of this one, would cost more in total than a new tangent.
  template <typename Impl>
  bool wants_tangent(const Impl& s) const {
    const double goal = s.goal(), rate = _after / _before;
    if (!(_after > goal)) return false;
    return std::log(goal / _after) / std::log(std::min(rate, 0.99)) > price_of_a_tangent;
  }

  SNESLineSearch _search;
  Vec _x = nullptr, _f = nullptr, _y = nullptr, _trial = nullptr, _trial_f = nullptr;
  double _before = 0, _after = 0, _merit_before = std::numeric_limits<double>::quiet_NaN();
  bool _has_merit = true;
  bool _settled = false;             ///< pressures, and therefore x, have been changed
  double _gap_before = 0;            ///< r_p^T C^-1 r_p / 2
  Eigen::VectorXd _pressure_change;  ///< C^-1 r_p
};

}  // namespace

PetscErrorCode Equilibrium::Impl::step(SNESLineSearch search, void* context) {
  auto& self = *static_cast<Impl*>(context);
  return self.contain([&] { Step(search).take(self); });
}

}  // namespace phynness
