// The orders of several tools and what they make together (docs/theory.md, tools anywhere).
#include <cmath>

#include "coupled_field.hpp"

#include "evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// In parts of each tool's own compliance: how much is left of two tools' compliances once they oppose each
/// other. Below, they are so close that what they ask for apart is given up
/// (docs/decisions/coupled-tools.md).
constexpr double least_apart = 0.05;

/// Part of all tools' energies that counts for each order: 0 would make two tools that agree, and so have
/// nothing left to do in either order, take turns with their smallest contradiction.
constexpr double equal_part = 0.05;

/// Of the rotation of the surface around a point that one tool makes, the part by which the body turns for
/// the tool that comes second (docs/decisions/coupled-tools.md).
constexpr double turned_part = 0.7;

/// Bodies of which half is turned: see curvature. Linear laws, which turn nothing, have 1e-6, nonlinear ones 0.05 and
/// more.
constexpr double half_curved = 0.005;

/// Part of all orders' weights below which what an order leaves to the others turns its field no more: where nothing is
/// left there is no mean of the rotations, but networks' fields have a part that stays.
constexpr double least_turned = 1e-6;

/// Points that miss their tools by more than this part of the largest displacement do not follow them.
constexpr double follows = 1e-8;

class Solver : private CoupledField {
 public:
  Solver(const phn_model& model, Coupling& coupling, const Vector* targets) : CoupledField(model, coupling, targets) {}

  CoupledResult run() {
    const std::int32_t n = _c.n_tools;
    double far = 0;
    _c.n_sets = n > 1 && !schema::traits(_model.family).proportional ? 1 + n : 1;
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
    // What fields do at the points that forces do not know of: as the undeformed body does it.
    miss();
    if (correct()) {
      for (std::int32_t s = 0; s < n; ++s) add_at_rest(0, s, _c.right[s], 1);
    }
    result.residual = miss();
    result.settled = result.residual <= follows * far;
    if (!has_energy(_model)) result.energy = 0;
    for (std::int32_t s = 0; s < n; ++s) _c.point[s].own = _targets[s];
    return finite() ? result : give_up(far);
  }

 private:
  /// Order i: tool i displaces the body alone, then the others move their points the rest of the way while it
  /// holds its own. All orders together, each with the more weight the more its tool does once others hold
  /// theirs: one that others move along does nothing, and is not felt. Sets forces and adds up the field.
  /// @return energy
  double combine_orders() {
    const std::int32_t n = _c.n_tools;
    const bool linear = schema::traits(_model.family).proportional;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.energy[i] = respond(i, _targets[i]);
      _c.alone[i] = _c.point[i].force;
    }
    for (std::int32_t i = 0; i < n; ++i) {
      find_derivatives(i);
      hold_others(i);
    }
    find_weights();
    // In a linear body all orders say the same, unless tools are too near each other; weights of their own would bend
    // it.
    for (std::int32_t i = 0; i < n && linear; ++i) _c.weight[i] = 1.0 / n;
    for (std::int32_t i = 0; i < n; ++i) add_order_to_field(i);
    double energy = 0;
    for (std::int32_t i = 0; i < n; ++i) _c.forces[i] = {};
    for (std::int32_t i = 0; i < n; ++i) {
      add_order_to_forces(i);
      energy += _c.weight[i] * _c.energy[i];
    }
    if (has_energy(_model) && !linear) add_change_of_weights(energy);
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
      if (j != i && !schema::traits(_model.family).proportional) _c.energy[i] += bend(i, j, force[j]);
    }
    carry_back(i, force);
    force[i] += _c.alone[i];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) _c.forces[j] += _c.weight[i] * force[j];
  }

  /// v of rotated for tool j, over what tool i makes of its place.
  double turned_by(std::int32_t i, std::int32_t j) const {
    const double curved = _c.point[i].curved + _c.point[j].curved, area = _c.point[j].area;
    return area > 0 ? turned_part / 2 / area * curved / (curved + 2 * half_curved * half_curved) : 0;
  }

  /// The field of what order i leaves to the others.
  std::int32_t set_of(std::int32_t i) const { return turns() ? 1 + i : 0; }

  /// What order i leaves to the others, turned back to where the body has not been turned by tool i, and the
  /// forces in the undeformed body for it.
  void hold_others(std::int32_t i) {
    const std::int32_t n = _c.n_tools;
    for (std::int32_t j = 0; j < n; ++j) {
      Vector &rest = _c.rest[at(i, j)], &turned = _c.turned[at(i, j)];
      rest = turned = {};
      if (j == i) continue;
      if (turns()) turned = turned_by(i, j) * displaced(place(n + j), i);
      rest = rotated_back(turned, _targets[j] - displaced(j, i));
    }
    pull_all(_c.rest + at(i, 0), _c.pulled + at(i, 0));
  }

  /// Forces of the undeformed body at all points for displacements of theirs.
  void pull_all(const Vector* moved, Vector* pulled) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      pulled[j] = {};
      for (std::int32_t s = 0; s < _c.n_tools; ++s) pulled[j] += _c.stiffness[at(j, s)] * moved[s];
    }
  }

  /// From derivatives by what order i leaves to the others, as turned back, to those by all tools'
  /// displacements.
  /// @param force  of all tools, that of i 0; becomes the latter
  void carry_back(std::int32_t i, Vector* force) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      if (j == i) continue;
      const Vector &turned = _c.turned[at(i, j)], &rest = _c.rest[at(i, j)], g = force[j];
      force[j] = rotated(turned, g);
      force[i] -= transposed_times(_c.derivative[at(j, i)], force[j]);
      if (!turns()) continue;
      const Vector change = rotation_gradient(turned, g, rotated(turned, rest));
      force[i] += turned_by(i, j) * transposed_times(_c.derivative[at(place(_c.n_tools + j), i)], change);
    }
  }

  /// Weight i: energy of what tool i still does in the other orders, as the undeformed body has it alone, and
  /// a part of all tools' energies, which keeps tools equal that agree.
  void find_weights() {
    const std::int32_t n = _c.n_tools;
    double all = 0;
    for (std::int32_t i = 0; i < n; ++i) all += dot(_targets[i], _c.point[i].stiffness * _targets[i]);
    _sum = 0;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.weight[i] = equal_part * std::fabs(all);
      for (std::int32_t j = 0; j < n; ++j) {
        if (j != i) _c.weight[i] += dot(_c.pulled[at(j, i)], _c.point[i].compliance * _c.pulled[at(j, i)]);
      }
      _sum += _c.weight[i];
    }
    for (std::int32_t i = 0; i < n; ++i) _c.weight[i] = _sum > 0 ? _c.weight[i] / _sum : 1.0 / n;
  }

  /// Adds what the change of the weights with the displacements does to the energy: forces are its gradient.
  void add_change_of_weights(double energy) {
    const std::int32_t n = _c.n_tools;
    if (!(_sum > 0)) return;
    double apart = 0;  // the orders' energies from the mean one
    for (std::int32_t i = 0; i < n; ++i) apart += (_c.energy[i] - energy) / _sum;
    for (std::int32_t i = 0; i < n; ++i)
      _c.forces[i] += (apart * equal_part * 2) * (_c.point[i].stiffness * _targets[i]);
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

  /// What tool j does beyond linear when it moves its point by what order i leaves to it in a body that
  /// others hold: taken as what it does beyond linear alone, at as much of that as would be left of it if
  /// others held theirs.
  /// @param pulled  its gradient is added. @return energy
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

  /// From the undeformed body's derivatives of the points by the p: the forces that move the points by given
  /// displacements, and of each tool what of a displacement of its own is left when the others hold theirs.
  /// Compliances are scaled to 1 for each tool alone; where they are almost singular, tools are too near each
  /// other to be told apart: there the inverse goes to 0 with the eigenvalue instead of to infinity.
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
    _apart = true;
    for (std::int32_t e = 0; e < n; ++e) _apart = _apart && _c.work[e * n + e] >= least_apart;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      HeldPoint& point = _c.point[t];
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Matrix scaled = inverse_block(t, s);
        _c.stiffness[at(t, s)] = point.root * scaled * _c.point[s].root;
        // Others can only hold a point tighter.
        if (s == t) point.relative = point.inverse_root * inverse_of_stiffness(scaled, 1) * point.root;
      }
    }
  }

  /// Of the inverse of the scaled compliances. @pre they are diagonalized
  Matrix inverse_block(std::int32_t t, std::int32_t s) const {
    const std::int32_t n = 3 * _c.n_tools;
    Matrix block = {};
    for (std::int32_t e = 0; e < n; ++e) {
      const double value = _c.work[e * n + e];
      const double inverse = value >= least_apart ? 1 / value : std::fmax(value, 0.0) / (least_apart * least_apart);
      for (int k = 0; k < 9; ++k)
        block.a[k] += _c.vectors[(3 * t + k / 3) * n + e] * inverse * _c.vectors[(3 * s + k % 3) * n + e];
    }
    return block;
  }

  /// right becomes the change of the p that makes up for it in the undeformed body, as far as tools can be
  /// told apart.
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

  /// Zeros: sums left the range of numbers.
  CoupledResult give_up(double far) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.point[t].force = _c.point[t].own = {};
    clear_field();
    return {false, far, 0};
  }

  double _sum = 0;     ///< of the weights before they were made to add up to 1
  bool _apart = true;  ///< no two tools are too near each other to be told apart
};

}  // namespace

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  c.model = &model;
  const auto t = static_cast<std::size_t>(c.max_tools);
  // One tool alone turns nothing for another.
  const std::size_t n_places = t > 1 ? 2 * t : t, n_sets = t > 1 ? 1 + t : 1, n_locals = 3 * n_places * t;
  c.point = arena.take<HeldPoint>(t);
  c.local = arena.take<LocalResponse>(n_locals);
  auto* rows = arena.take<double>(3 * model.n_basis, n_locals + 1);
  for (std::size_t i = 0; c.local && rows && i < n_locals; ++i) c.local[i].rows = rows + 3 * model.n_basis * i;
  c.pair.rows = rows ? rows + 3 * model.n_basis * n_locals : nullptr;
  c.rest_response = arena.take<Matrix>(n_locals);
  c.rest_gradient = arena.take<double>(9 * t, model.n_basis);
  c.node_basis = arena.take<double>(3 * t, model.n_basis);
  c.field = arena.take<FieldPart>(3 * n_sets * t);
  c.field_basis = arena.take<double>(3 * n_sets * t, model.n_basis);
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
  c.derivative = arena.take<Matrix>(n_places * t);
  c.rest = arena.take<Vector>(t * t);
  c.pulled = arena.take<Vector>(t * t);
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
