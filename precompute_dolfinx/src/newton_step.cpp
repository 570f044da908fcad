// How far to go along the direction that SNES has computed, and whether the next one deserves a new tangent.
#include <algorithm>
#include <cmath>
#include <limits>

#include "equilibrium_impl.hpp"
#include "newton_cg.hpp"

namespace phynness {
namespace {

// A cheap step must at least halve the residual; a new tangent does better for what three or four cost.
constexpr double cheap_step_worth = 0.5;
// A tangent, assembled and factorized, costs about as much as seven cheap steps (Case 3: P1 6, p1-p1 7, quadratic
// elements 10).
constexpr double price_of_a_tangent = 7;
// Armijo's constant, customary: any decrease that is not an artefact.
constexpr double decrease = 1e-4;

double dot(Vec a, Vec b) {
  PetscScalar value = 0;
  PHYNNESS_PETSC(VecDot(a, b, &value));
  return value;
}

double norm(Vec a) {
  PetscReal value = 0;
  PHYNNESS_PETSC(VecNorm(a, NORM_2, &value));
  return value;
}

/// x <- x - length * y. (Impl is private to Equilibrium, hence the templates.)
class Step {
 public:
  Step(SNESLineSearch search, KSP ksp) : _search(search), _ksp(ksp) {
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
    } else {
      _after = _before;
      s.reaction_norm = reactions;
    }
    PHYNNESS_PETSC(SNESLineSearchSetNorms(_search, norm(_x), _after, norm(_y)));
    PHYNNESS_PETSC(SNESLineSearchSetReason(_search, SNES_LINESEARCH_SUCCEEDED));
  }

 private:
  /// With old factors, corrected by what the steps since have taught: whole or not at all.
  /// Each returns the length; 0: stay here and get a new tangent; negative: give up.
  template <typename Impl>
  double cheap(Impl& s) {
    s.quasi_newton.correct(_y);
    const bool finite = try_length(s, 1);
    s.refresh = !finite || _after > cheap_step_worth * _before || wants_tangent(s);
    return finite && _after < _before ? 1 : 0;
  }

  template <typename Impl>
  double newton(Impl& s) {
    // Newton's method would go to the saddle.
    if (s.has_energy() && !s.convex && s.negative_pivots() > 0) return make_convex(s);
    bool negative_curvature = false;
    if (s.convex) {
      const auto cg = newton_cg(_ksp, s.tangent.exact(), _f, _y);
      s.counts.substitutions += cg.iterations;
      negative_curvature = cg.negative_curvature;
    }
    const double slope = dot(_f, _y);  // minus the energy's derivative along the step
    if (s.has_energy() && !(slope > 0)) return s.convex ? -1 : make_convex(s);

    // Mixed elements have only the residual to go by; where it resists, a shorter increment does more.
    const int most_trials = s.has_energy() ? 20 : 6;
    double low = 0, high = std::numeric_limits<double>::infinity(), low_slope = slope, length = 1;
    for (int trial = 0; trial < most_trials; ++trial) {
      const bool finite = try_length(s, length);
      const double here = finite && s.has_energy() ? dot(_trial_f, _y) : 0;
      if (finite && good_enough(s, length, slope, here)) {
        // Still half as steep as at the start, where the curvature was negative: the valley is further on.
        if (negative_curvature && here > 0.5 * slope && length < 100 && !std::isfinite(high)) {
          low = length;
          low_slope = here;
          length *= 2;
          continue;
        }
        s.refresh = s.convex || wants_tangent(s);
        s.convex = negative_curvature;
        return length;
      }
      high = length;
      // Where the slope has changed its sign the secant finds its zero.
      const double fraction = here < 0 ? std::clamp(low_slope / (low_slope - here), 0.1, 0.7) : 0.5;
      length = low + fraction * (high - low);
    }
    return s.has_energy() && !s.convex ? make_convex(s) : -1;
  }

  template <typename Impl>
  double make_convex(Impl& s) {
    s.convex = s.refresh = true;
    return 0;
  }

  /// @return false if the residual there is not finite (J <= 0 in a law with ln J)
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
    if (!s.has_energy()) return shorter;
    if (std::abs(here) <= 0.5 * slope) return true;
    const double energy = s.body.energy(s.state);
    if (std::isnan(_energy_before)) {
      const auto moved = s.state;
      s.gather(_x);
      _energy_before = s.body.energy(s.state);
      s.state = moved;
    }
    // Where rounding hides the step's share of the energy, the residual still shows it.
    if (slope * length < 1e-9 * std::abs(_energy_before)) return shorter;
    return energy <= _energy_before - decrease * length * slope;
  }

  /// Cheap steps go on at the rate of this one: would there be more of them than a tangent costs?
  template <typename Impl>
  bool wants_tangent(const Impl& s) const {
    const double goal = s.goal(), rate = _after / _before;
    if (!(_after > goal)) return false;
    return std::log(goal / _after) / std::log(std::min(rate, 0.99)) > price_of_a_tangent;
  }

  SNESLineSearch _search;
  KSP _ksp;
  Vec _x = nullptr, _f = nullptr, _y = nullptr, _trial = nullptr, _trial_f = nullptr;
  double _before = 0, _after = 0, _energy_before = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace

PetscErrorCode Equilibrium::Impl::step(SNESLineSearch search, void* context) {
  auto& self = *static_cast<Impl*>(context);
  KSP ksp;
  PetscCall(SNESGetKSP(self.snes, &ksp));
  Step(search, ksp).take(self);
  return 0;
}

}  // namespace phynness
