// The orders in which several tools act, and their combination (docs/theory.md, tools anywhere).
#include <cmath>

#include "tools/coupled_field.hpp"

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Smallest compliance of opposing displacements of two tools, as a fraction of each tool's own compliance. Below it
/// the tools are so close that opposing displacements are followed only in part (docs/decisions/coupled-tools.md).
/// Means under round tools are as well known as that (docs/decisions/several-round-tools.md).
constexpr double least_apart = 0.05, least_apart_round = 0.002;

/// Fraction of all tools' energies that is added to the weight of each order. With 0, the weights of two tools with
/// consistent displacements, which leave nothing to do in either order, would jump with their smallest difference.
constexpr double equal_part = 0.05;

/// Round tools that are well apart, with compliances above this, have no such part: the smallest difference that they
/// can have is large, and a tool that exerts no force does not count at all. It is whole again at half of this.
constexpr double well_apart = 0.1;

/// Fraction of the surface's rotation around a point, caused by the first tool, by which the body counts as turned for
/// the second tool (docs/decisions/coupled-tools.md).
constexpr double turned_part = 0.7;

/// Curvature (see curvature) at which half of the rotation is used. Linear laws, for which fields must not be turned,
/// have 1e-6; nonlinear laws have 0.05 and more.
constexpr double half_curved = 0.005;

/// Fraction of all orders' weights below which the field that an order leaves to the others is not turned: where
/// nothing is left, the mean of the rotations is undefined, but fields of networks have a constant part.
constexpr double least_turned = 1e-6;

/// A round tool's force may be as many times the largest that it had alone in training, plus 1, if it does not feel the
/// others, and just that if they are nearly one: what they add then strains the body between them.
constexpr double beyond_training = 2;

/// A point that is farther from its tool than this fraction of the largest displacement does not follow it.
constexpr double follows = 1e-8;

class Solver : private CoupledField {
 public:
  Solver(const phn_model& model, Coupling& coupling, const Vector* targets) : CoupledField(model, coupling, targets) {}

  CoupledResult run() {
    const std::int32_t n = _c.n_tools;
    double far = 0;
    _c.n_sets = n > 1 && !schema::traits(_model.kind).proportional ? 1 + n : 1;
    for (std::int32_t s = 0; s < n; ++s) {
      prepare(s);
      far = std::fmax(far, length(_targets[s].x));
    }
    if (_round) match_round_tools();
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
    miss();
    if (correct()) {
      for (std::int32_t s = 0; s < n; ++s) add_at_rest(0, s, _c.right[s], 1);
    }
    result.residual = miss();
    result.settled = result.residual <= follows * far;
    for (std::int32_t t = 0; t < n && n > 1; ++t)
      result.beyond = result.beyond || is_beyond(t, 1 + beyond_training * _compliance);
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
      _c.alone[i] = _c.point[i].force;
    }
    for (std::int32_t i = 0; i < n; ++i) {
      find_derivatives(i);
      hold_others(i);
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
      const Vector own = _c.point[j].compliance * _c.pulled[at(i, j)];
      add_at_rest(set_of(i), j, own, _c.weight[i]);
      if (j == i || !turns()) continue;
      const double part = dot(_c.pulled[at(i, j)], own);
      turned += part * _c.turned[at(i, j)];
      all += part;
    }
    all += least_turned * _sum;
    if (turns()) _c.field_turn[set_of(i)] = all > 0 ? turned / all : Vector{};
  }

  void add_order_to_forces(std::int32_t i) {
    Vector force[most_coupled];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      const Vector& pulled = _c.pulled[at(i, j)];
      _c.energy[i] += dot(_c.rest[at(i, j)], pulled) / 2;
      force[j] = j == i ? Vector{} : pulled;
      if (j != i && !schema::traits(_model.kind).proportional) _c.energy[i] += bend(i, j, force[j]);
    }
    carry_back(i, force);
    force[i] += _c.alone[i];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) _c.forces[j] += _c.weight[i] * force[j];
  }

  /// Less than x where tools i and j have a linear law.
  double if_nonlinear(std::int32_t i, std::int32_t j, double x) const {
    const double curved = _c.point[i].curved + _c.point[j].curved;
    return x * curved / (curved + 2 * half_curved * half_curved);
  }

  /// Rotation vector (argument of rotated) for tool j, relative to the rotation that tool i causes at its point.
  double turned_by(std::int32_t i, std::int32_t j) const {
    const double area = _c.point[j].area;
    return area > 0 ? if_nonlinear(i, j, turned_part / 2 / area) : 0;
  }

  /// What the square of a displacement r that order i leaves to round tool j adds to it [1/m]: with it the distance of
  /// the tools changes as Green's strain says, by r . e + r . r / 2 L, as far as the others hold the body.
  Vector stretch(std::int32_t i, std::int32_t j) const {
    const HeldPoint &by = _c.point[i], &to = _c.point[j];
    const Vector apart = to.middle - by.middle;
    const double square = dot(apart, apart) + (by.spread + to.spread) / 2;
    const double part = turns() && square > 0 ? if_nonlinear(i, j, 0.5 / square) : 0;
    return part * (apart - to.relative * apart);
  }

  /// The set with the field that order i leaves to the others.
  std::int32_t set_of(std::int32_t i) const { return turns() ? 1 + i : 0; }

  /// The displacements that order i leaves to the others, turned back by the rotation that tool i causes and stretched,
  /// and their forces in the undeformed body.
  void hold_others(std::int32_t i) {
    const std::int32_t n = _c.n_tools;
    for (std::int32_t j = 0; j < n; ++j) {
      Vector &rest = _c.rest[at(i, j)], &turned = _c.turned[at(i, j)];
      rest = turned = {};
      if (j == i) continue;
      if (turns()) turned = turned_by(i, j) * displaced(place(n + j), i);
      rest = rotated_back(turned, _targets[j] - displaced(j, i));
      _c.left[at(i, j)] = rest;
      if (_round) rest += dot(rest, rest) * stretch(i, j);
    }
    pull_all(_c.rest + at(i, 0), _c.pulled + at(i, 0));
  }

  /// Forces of the undeformed body at all points for given displacements of the points.
  void pull_all(const Vector* moved, Vector* pulled) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      pulled[j] = {};
      for (std::int32_t s = 0; s < _c.n_tools; ++s) pulled[j] += _c.stiffness[at(j, s)] * moved[s];
    }
  }

  /// Chain rule from the displacements that order i leaves to the others, turned back and stretched, to the
  /// displacements of all tools.
  /// @param force  derivatives by the former, 0 for tool i; replaced by derivatives by the latter
  void carry_back(std::int32_t i, Vector* force) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      if (j == i) continue;
      const Vector &turned = _c.turned[at(i, j)], &rest = _c.left[at(i, j)];
      if (_round) force[j] += 2 * dot(stretch(i, j), force[j]) * rest;
      const Vector g = force[j];
      force[j] = rotated(turned, g);
      force[i] -= transposed_times(_c.derivative[at(j, i)], force[j]);
      if (!turns()) continue;
      const Vector change = rotation_gradient(turned, g, rotated(turned, rest));
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
      _c.weight[i] = _equal_part * std::fabs(all);
      for (std::int32_t j = 0; j < n; ++j) {
        if (j != i) _c.weight[i] += dot(_c.pulled[at(j, i)], _c.point[i].compliance * _c.pulled[at(j, i)]);
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
      _c.forces[i] += (apart * _equal_part * 2) * (_c.point[i].stiffness * _targets[i]);
    for (std::int32_t first = 0; first < n; ++first) {
      Vector own[most_coupled], force[most_coupled];
      for (std::int32_t i = 0; i < n; ++i) {
        const double factor = i == first ? 0 : 2 * (_c.energy[i] - energy) / _sum;
        own[i] = factor * (_c.point[i].compliance * _c.pulled[at(first, i)]);
      }
      pull_all(own, force);
      force[first] = {};
      carry_back(first, force);
      for (std::int32_t i = 0; i < n; ++i) _c.forces[i] += force[i];
    }
  }

  /// Nonlinear part of the energy when tool j moves its point by the displacement that order i leaves to it while other
  /// tools hold their points. It is taken from the response of tool j alone, at that part of the displacement which
  /// would remain if the others held their points.
  /// @param pulled  the gradient is added to it. @return energy
  double bend(std::int32_t i, std::int32_t j, Vector& pulled) {
    HeldPoint& point = _c.point[j];
    const Vector z = point.relative * _c.rest[at(i, j)];
    const double energy = respond(j, z);
    const Vector linear = point.stiffness * z;
    pulled += transposed_times(point.relative, point.force - linear);
    add_response(set_of(i), j, _c.weight[i]);
    add_at_rest(set_of(i), j, z, -_c.weight[i]);
    return energy - dot(z, linear) / 2;
  }

  /// Computes, from the derivatives of the points by the p in the undeformed body, the forces that move the points by
  /// given displacements, and for each tool the part of its displacement that remains when the others hold their
  /// points. Compliances are scaled to 1 for each tool alone. An almost singular compliance means that tools are too
  /// close together to be distinguished; there the inverse goes to 0 with the eigenvalue instead of to infinity.
  void find_stiffness() {
    const std::int32_t n = 3 * _c.n_tools;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Matrix scaled = _c.point[t].root * rest_block(t, s) * _c.point[s].inverse_root;
        for (int k = 0; k < 9; ++k) _c.work[(3 * t + k / 3) * n + 3 * s + k % 3] = scaled.a[k];
      }
    }
    for (std::int32_t i = 0; i < n; ++i) {
      for (std::int32_t j = 0; j < i; ++j)
        _c.work[i * n + j] = _c.work[j * n + i] = (_c.work[i * n + j] + _c.work[j * n + i]) / 2;
    }
    diagonalize(_c.work, n, _c.vectors);
    double least = _c.work[0];
    for (std::int32_t e = 1; e < n; ++e) least = std::fmin(least, _c.work[e * n + e]);
    _compliance = std::fmax(least, 0.0);
    _least = _round ? least_apart_round : least_apart;
    _apart = least >= _least;
    if (_round) _equal_part *= std::fmin(1.0, std::fmax(0.0, 2 * (well_apart - least) / well_apart));
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      HeldPoint& point = _c.point[t];
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Matrix scaled = inverse_block(t, s);
        _c.stiffness[at(t, s)] = point.root * scaled * _c.point[s].root;
        // Other tools can only stiffen a point.
        if (s == t) point.relative = point.inverse_root * inverse_of_stiffness(scaled, 1) * point.root;
      }
    }
  }

  /// Block (t, s) of the inverse of the scaled compliances. @pre they are diagonalized
  Matrix inverse_block(std::int32_t t, std::int32_t s) const {
    const std::int32_t n = 3 * _c.n_tools;
    Matrix block = {};
    for (std::int32_t e = 0; e < n; ++e) {
      const double value = _c.work[e * n + e];
      const double inverse = value >= _least ? 1 / value : std::fmax(value, 0.0) / (_least * _least);
      for (int k = 0; k < 9; ++k)
        block.a[k] += _c.vectors[(3 * t + k / 3) * n + e] * inverse * _c.vectors[(3 * s + k % 3) * n + e];
    }
    return block;
  }

  /// Replaces `right` by the change of the p that produces it in the undeformed body, as far as the tools can be
  /// distinguished.
  bool correct() {
    if (!_apart) {
      pull_all(_c.right, _c.forces);
      for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.right[t] = _c.point[t].compliance * _c.forces[t];
      return true;
    }
    if (_c.n_tools == 1) return true;
    const std::int32_t n = 3 * _c.n_tools;
    double right[3 * most_coupled];
    for (std::int32_t i = 0; i < n; ++i) right[i] = _c.right[i / 3][i % 3];
    for (std::int32_t i = 0; i < n * n; ++i) _c.work[i] = _c.matrix[i];
    if (!solve_dense(_c.work, n, right)) return false;
    for (std::int32_t i = 0; i < n; ++i) _c.right[i / 3][i % 3] = right[i];
    return true;
  }

  /// Sets all results to zero after an overflow of sums.
  CoupledResult give_up(double far) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.point[t].force = _c.point[t].own = {};
    clear_field();
    return {false, false, far, 0};
  }

  double _sum = 0;                  ///< of the weights before normalization
  double _least = least_apart;      ///< smallest compliance of tools that can be distinguished
  double _compliance = 1;           ///< the smallest, of opposing displacements, as a fraction of each tool's own
  bool _apart = true;               ///< all tools can be distinguished
  double _equal_part = equal_part;  ///< depends on the places only
};

}  // namespace

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  c.model = &model;
  c.neighbours = find_neighbours(arena, model);
  c.n_corners = model.n_covered > 0 ? most_corners : 3;
  const auto t = static_cast<std::size_t>(c.max_tools);
  // With a single tool no rotations are needed.
  const std::size_t n_places = t > 1 ? 2 * t : t, n_sets = t > 1 ? 1 + t : 1,
                    n_corners = static_cast<std::size_t>(c.n_corners) * t, n_locals = n_corners * n_places;
  c.point = arena.take<HeldPoint>(t);
  c.local = arena.take<LocalResponse>(n_locals);
  auto* rows = arena.take<double>(3 * model.n_basis, n_locals + 1);
  for (std::size_t i = 0; c.local && rows && i < n_locals; ++i) c.local[i].rows = rows + 3 * model.n_basis * i;
  c.pair.rows = rows ? rows + 3 * model.n_basis * n_locals : nullptr;
  c.rest_response = arena.take<Matrix>(n_locals);
  c.rest_gradient = arena.take<double>(3 * n_corners, model.n_basis);
  c.node_basis = arena.take<double>(n_corners, model.n_basis);
  c.field = arena.take<FieldPart>(n_corners * n_sets);
  c.field_basis = arena.take<double>(n_corners * n_sets, model.n_basis);
  c.field_turn = arena.take<Vector>(n_sets);
  c.turn = arena.take<SurfaceTurn>(n_sets > 1);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  c.kernel = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  const auto n_shared = 3 * static_cast<std::size_t>(model.shared.n_modes);
  c.shared = arena.take<double>(n_shared > model.n_basis ? n_shared : model.n_basis);
  c.matrix = arena.take<double>(9 * n_places * t);
  c.work = arena.take<double>(9 * t * t);
  c.vectors = arena.take<double>(9 * t * t);
  c.stiffness = arena.take<Matrix>(t * t);
  c.wide = arena.take<Matrix>(t * t);
  c.vertex_mean = arena.take<double>(static_cast<std::size_t>(model.n_output) + n_shared);
  c.derivative = arena.take<Matrix>(n_places * t);
  c.rest = arena.take<Vector>(t * t);
  c.pulled = arena.take<Vector>(t * t);
  c.left = arena.take<Vector>(t * t);
  c.turned = arena.take<Vector>(t * t);
  c.right = arena.take<Vector>(t);
  c.forces = arena.take<Vector>(t);
  c.alone = arena.take<Vector>(t);
  c.energy = arena.take<double>(t);
  c.weight = arena.take<double>(t);
  return c;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets) {
  return Solver(model, coupling, targets).run();
}

}  // namespace PHN_RUNTIME
