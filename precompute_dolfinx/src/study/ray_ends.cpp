// The end of a ray before its last increment: at a fold, at a crushed cell, or at the force limit.
//
// Along a smooth path the work of the force is the change of the stored energy. Where the body snaps, or the mesh
// folds, energy is lost at once. Forces and their derivatives at both ends of a step give its work to fourth order, so
// that a curved path is not mistaken for a loss; steps that seem to lose energy are halved, which makes a loss stand
// out from the work and an error of the quadrature disappear.
#include <algorithm>
#include <cmath>

#include "solve/ray_solver.hpp"

namespace phynness {
namespace {

/// A step loses energy if work and change of energy differ by more than this share of the stored energy, independently
/// of its length (docs/decisions/ends-of-rays.md).
constexpr double share_of_energy = 0.01;
/// Rounding of a dimensionless energy: a sum over the cells of the body, whose volume and modulus are about 1, of
/// differences of numbers of order 1.
constexpr double rounding = 1e-12;
/// Two states at the same depth are on the same branch if their energies agree to this. Converged energies agree to
/// about the square of the solver's tolerance.
constexpr double same_branch = 1e-6;

double along(const PathPoint& point, const Eigen::VectorXd& direction) {
  return point.force.size() == 0 ? 0 : point.force.dot(direction);  // no force at rest
}

/// Work of the force from a to b: the integral of the cubic through forces and their derivatives.
double work(const PathPoint& a, const PathPoint& b, const Eigen::VectorXd& direction) {
  const double h = b.s - a.s;
  return h / 2 * (along(a, direction) + along(b, direction)) + h * h / 12 * (a.stiffness - b.stiffness);
}

double energy_lost(const PathPoint& a, const PathPoint& b, const Eigen::VectorXd& direction) {
  return work(a, b, direction) - (b.energy - a.energy);
}

bool differs(const PathPoint& a, const PathPoint& b, const Eigen::VectorXd& direction) {
  const double stored = std::max(std::abs(a.energy), std::abs(b.energy));
  return std::abs(energy_lost(a, b, direction)) > share_of_energy * stored + rounding;
}

bool is_resolved(const PathPoint& a, const PathPoint& b, double resolution) {
  const double middle = a.s + (b.s - a.s) / 2;
  return b.s - a.s <= resolution * (1 + 1e-9) || !(a.s < middle && middle < b.s);
}

/// Largest force of one tool, which has three parameters.
double largest_force(const Eigen::VectorXd& force) {
  double largest = 0;
  for (Eigen::Index first = 0; first < force.size(); first += 3)
    largest = std::max(largest, force.segment(first, std::min<Eigen::Index>(3, force.size() - first)).norm());
  return largest;
}

/// Value of s at which the smallest J passes `limit`, which it does between a and b. J falls about exponentially.
double depth_of(double limit, const PathPoint& a, const PathPoint& b) {
  if (!(a.min_jacobian > limit)) return a.s;
  const double t = std::log(a.min_jacobian / limit) / std::log(a.min_jacobian / b.min_jacobian);
  return a.s + t * (b.s - a.s);
}

}  // namespace

void RaySolver::make_stiffness_exact(PathPoint& point) {
  if (point.exact_stiffness) return;
  point.exact_stiffness = true;  // also if the linearization fails
  log_exceptions([&] {
    const auto linear = _equilibrium.linearize(point.state, _direction);
    if (linear.status == Status::converged) point.stiffness = _direction.dot(linear.tangent.col(0));
  });
}

bool RaySolver::loses_energy(PathPoint& from, PathPoint& to) {
  if (!differs(from, to, _direction)) return false;
  // Beyond a fold the estimated stiffness is far too large, which indicates the fold even if a long step hides the
  // loss.
  if (!is_resolved(from, to, _limits.ray.resolution)) return true;
  make_stiffness_exact(from);
  make_stiffness_exact(to);
  return differs(from, to, _direction);
}

bool RaySolver::is_crushed(const PathPoint& from, const PathPoint& to) {
  if (!_body.forms().checks_jacobian || !(to.min_jacobian < _limits.ray.min_jacobian)) return false;
  _end.reason = EndReason::crushed;
  _end.depth_m = depth_of(_limits.ray.min_jacobian, from, to);
  return true;
}

RaySolver::Search RaySolver::search_fold(bool all_tangents, PathPoint& to, int& iterations) {
  Path refined_path = _path;
  make_stiffness_exact(refined_path.last());
  PathPoint next = to;
  bool solved = true;  // false: there is no state `next` at the last target
  std::vector<double> targets{to.s};
  double loss = 0, fold_s = to.s;
  for (;;) {
    PathPoint& from = refined_path.last();
    const bool loses = solved && loses_energy(from, next);
    if (loses) {
      loss = energy_lost(from, next, _direction);
      fold_s = next.s;
    }
    if (loses || !solved) {
      next.s = targets.back();
      if (is_resolved(from, next, _limits.ray.resolution)) {
        _end.depth_m = from.s;
        _end.fold_depth_m = fold_s;
        _end.energy_lost_J = loss;
        return Search::fold;
      }
      targets.push_back(from.s + (next.s - from.s) / 2);
    } else {
      if (is_crushed(from, next)) return Search::crushed;
      targets.pop_back();
      if (targets.empty()) break;
      refined_path.append(std::move(next));
    }
    next = {};
    const auto step = try_advance(refined_path, targets.back(), all_tangents && targets.size() == 1, next);
    iterations += step.iterations;
    solved = step.status == Status::converged;
  }
  // Shorter steps may lead to another branch than the longer step.
  if (std::abs(next.energy - to.energy) > same_branch * std::abs(to.energy)) {
    _path = std::move(refined_path);
    to = std::move(next);
  }
  return Search::smooth;
}

bool RaySolver::accept(PathPoint to, bool all_tangents, int& iterations) {
  const RayLimits& ray = _limits.ray;
  // Where J has no meaning the law is linear, and its paths are straight.
  const bool searches = ray.find_folds && _body.forms().checks_jacobian && _end.fold_depth_m == 0;
  if (searches && differs(_path.last(), to, _direction)) {
    const auto found = search_fold(all_tangents, to, iterations);
    if (found == Search::crushed) return false;
    if (found == Search::fold && ray.stop_at_fold) {
      _end.reason = EndReason::fold;
      return false;
    }
  }
  if (is_crushed(_path.last(), to)) return false;
  if (_limits.max_force > 0 && largest_force(to.force) > _limits.max_force) _end.reason = EndReason::force_limit;
  _path.append(std::move(to));
  return true;
}

}  // namespace phynness
