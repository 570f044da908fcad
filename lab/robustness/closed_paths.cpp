#include "closed_paths.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <optional>
#include <phynness/precompute/probe_solver.hpp>

#include "equilibrium.hpp"
#include "scaling.hpp"

namespace phynness::robustness {
namespace {

using Vector3 = Eigen::Vector3d;

/// The state at the end of the path so far, in dimensionless form as in the solver.
class Walker {
 public:
  explicit Walker(const Body& b)
      : _scaling(Scaling::of(b.mesh, b.scene.material)),
        _body(scaled(b.mesh, _scaling.length_m),
              form_set(b.scene.material, b.scene.solver.element, _scaling.modulus_Pa)),
        _fixed(fixed_points(_body, b.sets.fixed)),
        _equilibrium(_body, displacement_dofs(_body, _fixed), b.scene.solver),
        _probe(b.scene.probe) {}

  void touch(std::int32_t node) {
    const double radius = _probe.kind == ProbeKind::patch ? _probe.tool_radius_m / _scaling.length_m : 0;
    _equilibrium.prescribe(tool_constraint(_body, {at_node(node)}, radius, _fixed));
    _state.assign(_body.n_dofs(), 0.0);
    _q.setZero();
    linearize();
  }

  /// Moves straight to the displacement [m], with halved steps if necessary. Returns false on failure.
  bool go(const Vector3& displacement_m) {
    const Vector3 from = _q, target = displacement_m / _scaling.length_m;
    constexpr double shortest = 1.0 / 64;
    for (double done = 0, step = 1; done < 1; step = std::min(step, 1 - done)) {
      const bool last = done + step >= 1;
      if (try_step(last ? target : Vector3(from + (done + step) * (target - from)))) {
        done = last ? 1 : done + step;
        step *= 2;
      } else if ((step /= 2) < shortest) {
        return false;
      }
    }
    return true;
  }

  Vector3 force_N() { return _equilibrium.force(_state) * _scaling.force_N(); }
  double energy_J() { return _body.energy(_state) * _scaling.energy_J(); }
  int negative_pivots() const { return _negative_pivots; }

 private:
  static Mesh scaled(Mesh mesh, double length_m) {
    mesh.nodes /= length_m;
    return mesh;
  }
  bool linearize() {
    auto linear = _equilibrium.linearize(_state, Eigen::MatrixXd::Identity(3, 3));
    if (linear.status != Status::converged || !linear.sensitivity.allFinite()) return false;
    _sensitivity = std::move(linear.sensitivity);
    _negative_pivots = linear.negative_pivots;
    return true;
  }
  bool try_step(const Vector3& q) {
    const auto before = _state;
    const Eigen::VectorXd predicted =
        Eigen::Map<const Eigen::VectorXd>(_state.data(), static_cast<Eigen::Index>(_state.size())) +
        _sensitivity * (q - _q);
    std::copy(predicted.data(), predicted.data() + predicted.size(), _state.begin());
    const auto& constraint = _equilibrium.constraint();
    constraint.complete(_state, constraint.G * q);
    const bool upright = _equilibrium.solve(_state).status == Status::converged &&
                         (!_body.forms().checks_jacobian || _body.min_jacobian(_state) > 0);
    if (upright && linearize()) {
      _q = q;
      return true;
    }
    _state = before;
    return false;
  }

  Scaling _scaling;
  Discretization _body;
  std::vector<char> _fixed;
  Equilibrium _equilibrium;
  ProbeSpec _probe;
  std::vector<double> _state;
  Eigen::MatrixXd _sensitivity;
  Vector3 _q = Vector3::Zero();
  int _negative_pivots = 0;
};

constexpr int radial_increments = 6;
struct RadialState {
  Vector3 force_N;
  double energy_J;
};
/// The state at point i of the circle, reached from rest in the given number of increments; empty on failure.
using Radial = std::function<std::optional<RadialState>(int i, int increments)>;

using Circle = std::function<Vector3(double angle)>;  ///< displacement [m]

std::vector<Circle> circles(const Vector3& inward, double radius) {
  const Vector3 t = inward.unitOrthogonal(), b = inward.cross(t);
  const double slant = radius * std::numbers::sqrt2 / 2;
  return {[=](double a) -> Vector3 { return radius * (std::cos(a) * inward + std::sin(a) * t); },
          [=](double a) -> Vector3 { return slant * (inward + std::cos(a) * t + std::sin(a) * b); }};
}

void walk(Walker& walker, std::int32_t node, const Circle& at, int n_points, const Radial& radial, PathTally& tally) {
  ++tally.paths;
  constexpr int steps_to_the_circle = 6;
  for (int i = 1; i <= steps_to_the_circle; ++i)
    if (!walker.go(at(0) * i / steps_to_the_circle)) {
      ++tally.open;
      return;
    }
  const Vector3 begin = walker.force_N();
  double work = 0, energy = walker.energy_J();
  Vector3 force = begin;
  for (int i = 1; i <= n_points; ++i) {
    const double turn = 2 * std::numbers::pi / n_points;
    const Vector3 from = at(turn * (i - 1)), to = i == n_points ? at(0) : at(turn * i);
    if (!walker.go(to)) {
      ++tally.open;
      return;
    }
    const Vector3 next = walker.force_N();
    work += (force + next).dot(to - from) / 2;
    force = next;
    energy = std::max(energy, walker.energy_J());
    ++tally.points;
    tally.indefinite += walker.negative_pivots() > 0;
    const auto expected = radial(i % n_points, radial_increments);
    if (!expected) continue;
    const double difference = (force - expected->force_N).norm() / expected->force_N.norm();
    ++tally.compared;
    if (difference > same_force) {
      ++tally.different;
      tally.radial_higher += expected->energy_J > walker.energy_J();
      const auto finer = radial(i % n_points, 4 * radial_increments);
      tally.finer_agrees += finer && (force - finer->force_N).norm() < same_force * force.norm();
    }
    if (difference > tally.largest_difference) {
      tally.largest_difference = difference;
      tally.worst_node = node;
      tally.worst_displacement_m = {to[0], to[1], to[2]};
    }
  }
  tally.largest_gap = std::max(tally.largest_gap, (force - begin).norm() / begin.norm());
  tally.largest_work = std::max(tally.largest_work, std::abs(work) / energy);
}

}  // namespace

PathTally walk_circles(const Body& body, const std::vector<std::int32_t>& nodes, double radius_m, int n_points) {
  Walker walker(body);
  ProbeSolver solver(body.scene, body.mesh, body.sets);
  const Points normals = node_normals(body.mesh);
  PathTally tally;
  constexpr int n_compared = 8;
  for (const auto node : nodes) {
    solver.touch({node});
    for (const auto& circle : circles(-normals.row(node).transpose(), radius_m)) {
      walker.touch(node);
      walk(
          walker, node, circle, n_points,
          [&](int i, int increments) -> std::optional<RadialState> {
            if (i % (n_points / n_compared) != 0) return std::nullopt;
            const Vector3 d = circle(2 * std::numbers::pi * i / n_points);
            const auto r = solver.solve({{d[0], d[1], d[2]}}, increments);
            if (r.status != Status::converged) return std::nullopt;
            return RadialState{Vector3::Map(r.force_N[0].data()), r.energy_J};
          },
          tally);
      std::fprintf(stderr, "\r  %d paths ", tally.paths);
    }
  }
  std::fprintf(stderr, "\r%20s\r", "");
  return tally;
}

}  // namespace phynness::robustness
