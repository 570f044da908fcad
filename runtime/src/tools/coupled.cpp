// Several tools of node probes: each tool's point is a constraint; what the response to one tool leaves to the others
// is their residual; the forces that move the points by the residuals are their multipliers. One tool acts first, and
// the others add what remains: the orders in which they act, and their combination (docs/theory.md, equation (u)).
#include <cmath>

#include "tools/multiplier.hpp"

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Fraction of all tools' energies that is added to the weight of each order. With 0, the weights of two tools with
/// consistent displacements, which leave nothing to do in either order, would jump with their smallest difference.
constexpr double equal_part = 0.05;

/// Fraction of the surface's rotation around a point, caused by the first tool, by which the body counts as turned for
/// the second tool (docs/decisions/coupled-tools.md).
constexpr double turned_part = 0.7;

/// Curvature (see curvature) at which half of the rotation is used. Linear laws, for which fields must not be turned,
/// have 1e-6; nonlinear laws have 0.05 and more.
constexpr double half_curved = 0.005;

/// Fraction of all orders' weights below which the field that an order leaves to the others is not turned: where
/// nothing is left, the mean of the rotations is undefined, but fields of networks have a constant part.
constexpr double least_turned = 1e-6;

/// A point that is farther from its tool than this fraction of the largest displacement does not follow it.
constexpr double follows = 1e-8;

class Solver : private Multipliers {
 public:
  Solver(const phn_model& model, Coupling& coupling, const Vector* targets) : Multipliers(model, coupling, targets) {}

  CoupledResult run() {
    const std::int32_t n = _c.n_tools;
    double far = 0;
    _c.n_sets = n > 1 && !schema::traits(_model.kind).proportional ? 1 + n : 1;
    for (std::int32_t s = 0; s < n; ++s) {
      prepare(s);
      far = std::fmax(far, length(_targets[s].x));
    }
    for (std::int32_t s = 0; s < n && turns(); ++s) prepare_turn(s);
    clear_field();
    CoupledResult result = {};
    if (n > 1) {
      set_rest_matrix();
      find_stiffness();
      result.energy = combine_orders();
    } else {
      result.energy = respond(0, _targets[0]);
      add_response(0, 0, 1);
    }
    // Displacements of the fields at the points that the forces do not include are corrected as in the undeformed body.
    constraint_residual();
    if (correct()) {
      for (std::int32_t s = 0; s < n; ++s) add_at_rest(0, s, _c.right[s], 1);
    }
    result.residual = constraint_residual();
    result.settled = result.residual <= follows * far;
    if (!_model.has_energy) result.energy = 0;
    for (std::int32_t s = 0; s < n; ++s) _c.point[s].own = _targets[s];
    return finite() ? result : give_up(far);
  }

 private:
  /// Order i: tool i displaces the body alone; then the other tools move their points the remaining distance while tool
  /// i holds its point. The result is a weighted mean over all orders. The weight of an order grows with the work that
  /// its tool still does while the others hold their points; a tool whose point the others already displace has no
  /// weight. Sets the forces and sums the field.
  /// @return energy
  double combine_orders() {
    const std::int32_t n = _c.n_tools;
    const bool linear = schema::traits(_model.kind).proportional;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.energy[i] = respond(i, _targets[i]);
      _c.single_force[i] = _c.point[i].force;
    }
    for (std::int32_t i = 0; i < n; ++i) {
      find_derivatives(i);
      find_residuals(i);
    }
    find_weights();
    // In a linear body all orders give the same result unless tools are too close together; weights that depend on the
    // displacements would make it nonlinear.
    for (std::int32_t i = 0; i < n && linear; ++i) _c.weight[i] = 1.0 / n;
    for (std::int32_t i = 0; i < n; ++i) add_order_to_field(i);
    double energy = 0;
    for (std::int32_t i = 0; i < n; ++i) _c.forces[i] = {};
    for (std::int32_t i = 0; i < n; ++i) {
      add_order_to_forces(i);
      energy += _c.weight[i] * _c.energy[i];
    }
    if (_model.has_energy && !linear) add_change_of_weights(energy);
    for (std::int32_t i = 0; i < n; ++i) _c.point[i].force = _c.forces[i];
    return energy;
  }

  void add_order_to_field(std::int32_t i) {
    add_response(0, i, _c.weight[i]);
    Vector turned = {};
    double all = 0;
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      const Vector own = _c.point[j].compliance * _c.multiplier[at(i, j)];
      add_at_rest(set_of(i), j, own, _c.weight[i]);
      if (j == i || !turns()) continue;
      const double part = dot(_c.multiplier[at(i, j)], own);
      turned += part * _c.turned[at(i, j)];
      all += part;
    }
    all += least_turned * _sum;
    if (turns()) _c.field_turn[set_of(i)] = all > 0 ? turned / all : Vector{};
  }

  void add_order_to_forces(std::int32_t i) {
    Vector force[most_coupled];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      const Vector& multiplier = _c.multiplier[at(i, j)];
      _c.energy[i] += dot(_c.residual[at(i, j)], multiplier) / 2;
      force[j] = j == i ? Vector{} : multiplier;
      if (j != i && !schema::traits(_model.kind).proportional) _c.energy[i] += nonlinear_energy(i, j, force[j]);
    }
    transpose_apply(i, force);
    force[i] += _c.single_force[i];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) _c.forces[j] += _c.weight[i] * force[j];
  }

  /// Rotation vector (argument of rotated) for tool j, relative to the rotation that tool i causes at its point.
  double turned_by(std::int32_t i, std::int32_t j) const {
    const double area = _c.point[j].area, curved = _c.point[i].curved + _c.point[j].curved;
    return area > 0 ? turned_part / 2 / area * curved / (curved + 2 * half_curved * half_curved) : 0;
  }

  /// The set with the field that order i leaves to the others.
  std::int32_t set_of(std::int32_t i) const { return turns() ? 1 + i : 0; }

  /// The displacements that order i leaves to the others, turned back by the rotation that tool i
  /// causes, and their forces in the undeformed body.
  void find_residuals(std::int32_t i) {
    const std::int32_t n = _c.n_tools;
    for (std::int32_t j = 0; j < n; ++j) {
      Vector &residual = _c.residual[at(i, j)], &turned = _c.turned[at(i, j)];
      residual = turned = {};
      if (j == i) continue;
      if (turns()) turned = turned_by(i, j) * displaced(place(n + j), i);
      residual = rotated_back(turned, _targets[j] - displaced(j, i));
    }
    multiply(_c.residual + at(i, 0), _c.multiplier + at(i, 0));
  }

  /// Chain rule from the displacements that order i leaves to the others, turned back, to the displacements
  /// of all tools.
  /// @param force  derivatives by the former, 0 for tool i; replaced by derivatives by the latter
  void transpose_apply(std::int32_t i, Vector* force) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      if (j == i) continue;
      const Vector &turned = _c.turned[at(i, j)], &residual = _c.residual[at(i, j)], g = force[j];
      force[j] = rotated(turned, g);
      force[i] -= transposed_times(_c.derivative[at(j, i)], force[j]);
      if (!turns()) continue;
      const Vector change = rotation_gradient(turned, g, rotated(turned, residual));
      force[i] += turned_by(i, j) * transposed_times(_c.derivative[at(place(_c.n_tools + j), i)], change);
    }
  }

  /// Weight i: the energy, in the undeformed body with tool i alone, of the displacements that the other orders leave
  /// to tool i, plus a fraction of all tools' energies, which gives tools with consistent displacements equal weights.
  void find_weights() {
    const std::int32_t n = _c.n_tools;
    double all = 0;
    for (std::int32_t i = 0; i < n; ++i) all += dot(_targets[i], _c.point[i].stiffness * _targets[i]);
    _sum = 0;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.weight[i] = equal_part * std::fabs(all);
      for (std::int32_t j = 0; j < n; ++j) {
        if (j != i) _c.weight[i] += dot(_c.multiplier[at(j, i)], _c.point[i].compliance * _c.multiplier[at(j, i)]);
      }
      _sum += _c.weight[i];
    }
    for (std::int32_t i = 0; i < n; ++i) _c.weight[i] = _sum > 0 ? _c.weight[i] / _sum : 1.0 / n;
  }

  /// Adds the forces that result from the change of the weights with the displacements, so that the forces remain the
  /// gradient of the energy.
  void add_change_of_weights(double energy) {
    const std::int32_t n = _c.n_tools;
    if (!(_sum > 0)) return;
    double apart = 0;  // largest deviation of an order's energy from the mean
    for (std::int32_t i = 0; i < n; ++i) apart += (_c.energy[i] - energy) / _sum;
    for (std::int32_t i = 0; i < n; ++i)
      _c.forces[i] += (apart * equal_part * 2) * (_c.point[i].stiffness * _targets[i]);
    for (std::int32_t first = 0; first < n; ++first) {
      Vector own[most_coupled], force[most_coupled];
      for (std::int32_t i = 0; i < n; ++i) {
        const double factor = i == first ? 0 : 2 * (_c.energy[i] - energy) / _sum;
        own[i] = factor * (_c.point[i].compliance * _c.multiplier[at(first, i)]);
      }
      multiply(own, force);
      force[first] = {};
      transpose_apply(first, force);
      for (std::int32_t i = 0; i < n; ++i) _c.forces[i] += force[i];
    }
  }

  /// Nonlinear part of the energy when tool j moves its point by the displacement that order i leaves to it while other
  /// tools hold their points. It is taken from the response of tool j alone, at that part of the displacement which
  /// would remain if the others held their points.
  /// @param multiplier  the gradient is added to it. @return energy
  double nonlinear_energy(std::int32_t i, std::int32_t j, Vector& multiplier) {
    Constraint& point = _c.point[j];
    const Vector z = point.relative * _c.residual[at(i, j)];
    const double energy = respond(j, z);
    const Vector linear = point.stiffness * z;
    multiplier += transposed_times(point.relative, point.force - linear);
    add_response(set_of(i), j, _c.weight[i]);
    add_at_rest(set_of(i), j, z, -_c.weight[i]);
    return energy - dot(z, linear) / 2;
  }

  /// Sets all results to zero after an overflow of sums.
  CoupledResult give_up(double far) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.point[t].force = _c.point[t].own = {};
    clear_field();
    return {false, far, 0};
  }

  double _sum = 0;  ///< of the weights before normalization
};

}  // namespace

Coupling* make_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  auto* made = arena.take<Coupling>(1);
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  c.model = &model;
  c.neighbours = find_neighbours(arena, model);
  const bool round = has_round_tools(model);
  c.n_corners = round ? most_corners : most_nodes;
  // With a single tool no rotations are needed.
  const std::size_t t = round ? 1 : static_cast<std::size_t>(c.max_tools), n_places = t > 1 ? 2 * t : 1,
                    n_sets = t > 1 ? 1 + t : 1, n_corners = static_cast<std::size_t>(c.n_corners) * t,
                    n_fields = n_corners * n_places;
  c.point = arena.take<Constraint>(t);
  c.field = arena.take<FieldPart>(n_corners * n_sets);
  c.field_basis = arena.take<double>(n_corners * n_sets, model.n_basis);
  c.field_turn = arena.take<Vector>(n_sets);
  c.kernel = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  c.displacement = arena.take<NodeField>(n_fields);
  auto* rows = arena.take<double>(3 * model.n_basis, n_fields + 1);
  for (std::size_t i = 0; c.displacement && rows && i < n_fields; ++i)
    c.displacement[i].rows = rows + 3 * model.n_basis * i;
  c.pair.rows = rows ? rows + 3 * model.n_basis * n_fields : nullptr;
  c.rest_response = arena.take<Matrix>(n_fields);
  c.rest_gradient = arena.take<double>(3 * n_corners, model.n_basis);
  c.response_basis = arena.take<double>(n_corners, model.n_basis);
  c.turn = arena.take<SurfaceTurn>(n_sets > 1);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  const auto n_shared = 3 * static_cast<std::size_t>(model.shared.n_modes);
  c.shared = arena.take<double>(n_shared > model.n_basis ? n_shared : model.n_basis);
  c.matrix = arena.take<double>(9 * n_places * t);
  c.work = arena.take<double>(9 * t * t);
  c.vectors = arena.take<double>(9 * t * t);
  c.stiffness = arena.take<Matrix>(t * t);
  c.derivative = arena.take<Matrix>(n_places * t);
  c.residual = arena.take<Vector>(t * t);
  c.multiplier = arena.take<Vector>(t * t);
  c.turned = arena.take<Vector>(t * t);
  c.right = arena.take<Vector>(t);
  c.forces = arena.take<Vector>(t);
  c.single_force = arena.take<Vector>(t);
  c.energy = arena.take<double>(t);
  c.weight = arena.take<double>(t);
  if (made != nullptr && !arena.overflow()) *made = c;
  return made;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets) {
  return Solver(model, coupling, targets).run();
}

}  // namespace PHN_RUNTIME
