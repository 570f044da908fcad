#include "coupled.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "small_matrices.hpp"
#include "tool_responses.hpp"

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

class Solver : private ToolResponses {
 public:
  Solver(const phn_model& model, Coupling& coupling, const double* targets)
      : ToolResponses(model, coupling), _targets(targets) {}

  CoupledResult run() {
    const std::int32_t n = _c.n_tools;
    double far = 0;
    _c.n_sets = n > 1 && !schema::traits(_model.family).proportional ? 1 + n : 1;
    for (std::int32_t s = 0; s < n; ++s) {
      prepare(s);
      far = std::fmax(far, length(_targets + 3 * s));
    }
    for (std::int32_t s = 0; s < n && turns(); ++s) prepare_turn(s);
    clear_field();
    CoupledResult result = {};
    if (n > 1) {
      set_rest_matrix();
      find_stiffness();
      result.energy = combine_orders();
    } else {
      result.energy = respond(0, _targets);
      add_response(0, 0, 1);
    }
    // What fields do at the points that forces do not know of: as the undeformed body does it.
    miss();
    if (correct()) {
      for (std::int32_t s = 0; s < n; ++s) add_at_rest(0, s, _c.right + 3 * s, 1);
    }
    result.residual = miss();
    result.settled = result.residual <= follows * far;
    if (!has_energy(_model)) result.energy = 0;
    for (std::int32_t s = 0; s < n; ++s) {
      for (int k = 0; k < 3; ++k) _c.point[s].own[k] = _targets[3 * s + k];
    }
    return finite() ? result : give_up(far);
  }

 private:
  FieldPart& field(std::int32_t set, std::int32_t s, std::int32_t i) const { return _c.field[at(set, s, i)]; }
  double* field_basis(std::int32_t set, std::int32_t s, std::int32_t i) const {
    return _c.field_basis + at(set, s, i) * _model.n_basis;
  }

  /// Order i: tool i displaces the body alone, then the others move their points the rest of the way while it
  /// holds its own. All orders together, each with the more weight the more its tool does once others hold
  /// theirs: one that others move along does nothing, and is not felt. Sets forces and adds up the field.
  /// @return energy
  double combine_orders() {
    const std::int32_t n = _c.n_tools;
    const bool linear = schema::traits(_model.family).proportional;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.energy[i] = respond(i, _targets + 3 * i);
      for (int k = 0; k < 3; ++k) _c.alone[3 * i + k] = _c.point[i].force[k];
    }
    for (std::int32_t i = 0; i < n; ++i) {
      find_derivatives(i);
      hold_others(i);
    }
    find_weights();
    // In a linear body all orders say the same, unless tools are too near each other; weights of their own would bend
    // it.
    for (std::int32_t i = 0; i < n && linear; ++i) _c.weight[i] = 1.0 / n;
    for (std::int32_t i = 0; i < n; ++i) {
      add_response(0, i, _c.weight[i]);
      double turned[3] = {0, 0, 0}, all = 0;
      for (std::int32_t j = 0; j < n; ++j) {
        double own[3];
        multiply(_c.point[j].compliance, _c.pulled + at(i, j, 0), own);
        add_at_rest(set_of(i), j, own, _c.weight[i]);
        if (j == i || !turns()) continue;
        const double part = dot(_c.pulled + at(i, j, 0), own);
        add_scaled(part, _c.turned + at(i, j, 0), 3, turned);
        all += part;
      }
      all += least_turned * _sum;
      for (int k = 0; k < 3 && turns(); ++k) _c.field_turn[3 * set_of(i) + k] = all > 0 ? turned[k] / all : 0;
    }
    double energy = 0;
    set_zero(_c.forces, 3 * static_cast<std::size_t>(n));
    for (std::int32_t i = 0; i < n; ++i) {
      double force[3 * most_coupled];
      for (std::int32_t j = 0; j < n; ++j) {
        const double* pulled = _c.pulled + at(i, j, 0);
        _c.energy[i] += dot(_c.rest + at(i, j, 0), pulled) / 2;
        for (int k = 0; k < 3; ++k) force[3 * j + k] = j == i ? 0 : pulled[k];
        if (j != i && !linear) _c.energy[i] += bend(i, j, force + 3 * j);
      }
      carry_back(i, force);
      add_scaled(1, _c.alone + 3 * i, 3, force + 3 * i);
      add_scaled(_c.weight[i], force, 3 * n, _c.forces);
      energy += _c.weight[i] * _c.energy[i];
    }
    if (has_energy(_model) && !linear) add_change_of_weights(energy);
    for (std::int32_t i = 0; i < 3 * n; ++i) _c.point[i / 3].force[i % 3] = _c.forces[i];
    return energy;
  }

  /// v of rotate for tool j, over what tool i makes of its place.
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
      double *rest = _c.rest + at(i, j, 0), *turned = _c.turned + at(i, j, 0), left[3];
      for (int k = 0; k < 3; ++k) rest[k] = turned[k] = 0;
      if (j == i) continue;
      displaced(j, i, left);
      for (int k = 0; k < 3; ++k) left[k] = _targets[3 * j + k] - left[k];
      if (turns()) displaced(place(n + j), i, turned);
      for (int k = 0; k < 3; ++k) turned[k] *= turned_by(i, j);
      rotate(turned, true, left, rest);
    }
    pull_all(_c.rest + at(i, 0, 0), _c.pulled + at(i, 0, 0));
  }

  /// Forces of the undeformed body at all points for displacements of theirs.
  void pull_all(const double* moved, double* pulled) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      set_zero(pulled + 3 * j, 3);
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        double by[3];
        multiply(_c.stiffness + at9(j, s), moved + 3 * s, by);
        add_scaled(1, by, 3, pulled + 3 * j);
      }
    }
  }

  /// From derivatives by what order i leaves to the others, as turned back, to those by all tools'
  /// displacements.
  /// @param force  of all tools, that of i 0; becomes the latter
  void carry_back(std::int32_t i, double* force) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      if (j == i) continue;
      const double *turned = _c.turned + at(i, j, 0), *rest = _c.rest + at(i, j, 0);
      double g[3], left[3], change[3], back[3];
      for (int k = 0; k < 3; ++k) g[k] = force[3 * j + k];
      rotate(turned, false, g, force + 3 * j);
      multiply_transposed(_c.derivative + at9(j, i), force + 3 * j, back);
      add_scaled(-1, back, 3, force + 3 * i);
      if (!turns()) continue;
      rotate(turned, false, rest, left);
      rotation_gradient(turned, g, left, change);
      multiply_transposed(_c.derivative + at9(place(_c.n_tools + j), i), change, back);
      add_scaled(turned_by(i, j), back, 3, force + 3 * i);
    }
  }

  /// Weight i: energy of what tool i still does in the other orders, as the undeformed body has it alone, and
  /// a part of all tools' energies, which keeps tools equal that agree.
  void find_weights() {
    const std::int32_t n = _c.n_tools;
    double all = 0;
    for (std::int32_t i = 0; i < n; ++i) {
      double linear[3];
      multiply(_c.point[i].stiffness, _targets + 3 * i, linear);
      all += dot(_targets + 3 * i, linear);
    }
    _sum = 0;
    for (std::int32_t i = 0; i < n; ++i) {
      _c.weight[i] = equal_part * std::fabs(all);
      for (std::int32_t j = 0; j < n; ++j) {
        if (j == i) continue;
        double own[3];
        multiply(_c.point[i].compliance, _c.pulled + at(j, i, 0), own);
        _c.weight[i] += dot(_c.pulled + at(j, i, 0), own);
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
    for (std::int32_t i = 0; i < n; ++i) {
      double linear[3];
      multiply(_c.point[i].stiffness, _targets + 3 * i, linear);
      add_scaled(apart * equal_part * 2, linear, 3, _c.forces + 3 * i);
    }
    for (std::int32_t first = 0; first < n; ++first) {
      double own[3 * most_coupled], force[3 * most_coupled];
      for (std::int32_t i = 0; i < n; ++i) {
        multiply(_c.point[i].compliance, _c.pulled + at(first, i, 0), own + 3 * i);
        for (int k = 0; k < 3; ++k) own[3 * i + k] *= i == first ? 0 : 2 * (_c.energy[i] - energy) / _sum;
      }
      pull_all(own, force);
      set_zero(force + 3 * first, 3);
      carry_back(first, force);
      add_scaled(1, force, 3 * n, _c.forces);
    }
  }

  /// What tool j does beyond linear when it moves its point by what order i leaves to it in a body that
  /// others hold: taken as what it does beyond linear alone, at as much of that as would be left of it if
  /// others held theirs.
  /// @param pulled  its gradient is added. @return energy
  double bend(std::int32_t i, std::int32_t j, double* pulled) {
    HeldPoint& point = _c.point[j];
    double z[3], linear[3], gradient[3], back[3];
    multiply(point.relative, _c.rest + at(i, j, 0), z);
    const double energy = respond(j, z);
    multiply(point.stiffness, z, linear);
    for (int k = 0; k < 3; ++k) gradient[k] = point.force[k] - linear[k];
    multiply_transposed(point.relative, gradient, back);
    add_scaled(1, back, 3, pulled);
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
        // root_t A_ts root_s^-1
        double moved[9], block[9];
        rest_block(t, s, moved);
        multiply_matrices(_c.point[t].root, moved, block);
        multiply_matrices(block, _c.point[s].inverse_root, moved);
        for (int k = 0; k < 9; ++k) _c.work[(3 * t + k / 3) * n + 3 * s + k % 3] = moved[k];
      }
    }
    for (std::int32_t i = 0; i < n; ++i) {
      for (std::int32_t j = 0; j < i; ++j)
        _c.work[i * n + j] = _c.work[j * n + i] = (_c.work[i * n + j] + _c.work[j * n + i]) / 2;
    }
    diagonalize(_c.work, n, _c.vectors);
    _apart = true;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        double scaled[9] = {}, half[9];
        for (std::int32_t e = 0; e < n; ++e) {
          const double value = _c.work[e * n + e];
          _apart = _apart && value >= least_apart;
          const double inverse = value >= least_apart ? 1 / value : std::fmax(value, 0.0) / (least_apart * least_apart);
          for (int k = 0; k < 9; ++k)
            scaled[k] += _c.vectors[(3 * t + k / 3) * n + e] * inverse * _c.vectors[(3 * s + k % 3) * n + e];
        }
        multiply_matrices(_c.point[t].root, scaled, half);
        multiply_matrices(half, _c.point[s].root, _c.stiffness + at9(t, s));
        if (s != t) continue;
        // Others can only hold a point tighter.
        HeldPoint& point = _c.point[t];
        double left[9];
        invert_stiffness(scaled, 1, left);
        multiply_matrices(point.inverse_root, left, half);
        multiply_matrices(half, point.root, point.relative);
      }
    }
  }

  std::size_t basis_of_set() const { return 3 * static_cast<std::size_t>(_c.n_tools) * _model.n_basis; }
  void clear_field() {
    set_zero(_c.field_turn, 3 * static_cast<std::size_t>(_c.n_sets));
    for (std::int32_t set = 0; set < _c.n_sets; ++set) {
      for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) field(set, 0, i) = {0, {0, 0, 0}};
      set_zero(field_basis(set, 0, 0), basis_of_set());
    }
  }

  /// Adds to the field `weight` times the latest response of tool s.
  void add_response(std::int32_t set, std::int32_t s, double weight) {
    const HeldPoint& point = _c.point[s];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      field(set, s, i).share += weight * point.node_share[i];
      add_scaled(weight, point.node_own[i], 3, field(set, s, i).own);
      add_scaled(weight, node_basis(s, i), basis_size(_model, node(point, i)), field_basis(set, s, i));
    }
  }

  /// Adds to the field what moves tool s's point by `weight` r in the undeformed body.
  void add_at_rest(std::int32_t set, std::int32_t s, const double* r, double weight) {
    for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i)
      move_at_rest(s, i, r, weight, field_basis(set, s, i), field(set, s, i).own);
  }

  /// right = what the points lack of their targets in the field. @return the largest distance
  double miss() {
    double largest = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      double* r = _c.right + 3 * t;
      for (int k = 0; k < 3; ++k) r[k] = _targets[3 * t + k];
      for (std::int32_t set = 0; set < _c.n_sets; ++set) {
        double sum[3] = {0, 0, 0}, by[3];
        for (std::int32_t s = 0; s < _c.n_tools; ++s) {
          const HeldPoint& point = _c.point[s];
          for (std::int32_t i = 0; i < point.n_nodes; ++i) {
            local_displacement(_c.local[at(t, s, i)], field(set, s, i).share, field(set, s, i).own,
                               basis_size(_model, node(point, i)), field_basis(set, s, i), by);
            add_scaled(1, by, 3, sum);
          }
        }
        rotate(_c.field_turn + 3 * set, false, sum, by);
        add_scaled(-1, by, 3, r);
      }
      largest = std::fmax(largest, length(r));
    }
    return largest;
  }

  /// right becomes the change of the p that makes up for it in the undeformed body, as far as tools can be
  /// told apart.
  bool correct() {
    const std::int32_t n = 3 * _c.n_tools;
    if (_apart) {
      for (std::int32_t i = 0; i < n * n; ++i) _c.work[i] = _c.matrix[i];
      if (_c.n_tools > 1) return solve_dense(_c.work, n, _c.right);
      return true;
    }
    pull_all(_c.right, _c.forces);
    for (std::int32_t t = 0; t < _c.n_tools; ++t) multiply(_c.point[t].compliance, _c.forces + 3 * t, _c.right + 3 * t);
    return true;
  }

  bool finite() const {
    bool all = all_finite(_c.field_turn, 3 * static_cast<std::size_t>(_c.n_sets));
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const HeldPoint& point = _c.point[t];
      all = all && all_finite(point.force, 3) && all_finite(point.own, 3);
    }
    for (std::int32_t set = 0; set < _c.n_sets; ++set) {
      for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) all = all && all_finite(field(set, 0, i).own, 3);
      all = all && all_finite(field_basis(set, 0, 0), basis_of_set());
    }
    return all;
  }

  /// Zeros: sums left the range of numbers.
  CoupledResult give_up(double far) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      HeldPoint& point = _c.point[t];
      for (int k = 0; k < 3; ++k) point.force[k] = point.own[k] = 0;
    }
    clear_field();
    return {false, far, 0};
  }

  const double* _targets;
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
  c.rest_response = arena.take<double>(9 * n_locals);
  c.rest_gradient = arena.take<double>(9 * t, model.n_basis);
  c.node_basis = arena.take<double>(3 * t, model.n_basis);
  c.field = arena.take<FieldPart>(3 * n_sets * t);
  c.field_basis = arena.take<double>(3 * n_sets * t, model.n_basis);
  c.field_turn = arena.take<double>(3 * n_sets);
  c.turn = arena.take<SurfaceTurn>(n_sets > 1);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  c.kernel = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  const auto n_shared = 3 * static_cast<std::size_t>(model.shared.n_modes);
  c.shared = arena.take<double>(n_shared > model.n_basis ? n_shared : model.n_basis);
  c.matrix = arena.take<double>(9 * n_places * t);
  c.work = arena.take<double>(9 * t * t);
  c.vectors = arena.take<double>(9 * t * t);
  c.stiffness = arena.take<double>(9 * t * t);
  c.derivative = arena.take<double>(9 * n_places * t);
  c.rest = arena.take<double>(9 * t * t);
  c.pulled = arena.take<double>(9 * t * t);
  c.turned = arena.take<double>(9 * t * t);
  c.right = arena.take<double>(3 * t);
  c.forces = arena.take<double>(3 * t);
  c.alone = arena.take<double>(3 * t);
  c.energy = arena.take<double>(t);
  c.weight = arena.take<double>(t);
  return c;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const double* targets) {
  return Solver(model, coupling, targets).run();
}

void coupled_field(const phn_model& model, const Coupling& c, PreparedNodes& prepared, double* scratch, double* one,
                   double* field) {
  for (std::int32_t set = 0; set < c.n_sets; ++set) {
    for (std::int32_t s = 0; s < c.n_tools; ++s) {
      const HeldPoint& point = c.point[s];
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        const auto at = static_cast<std::size_t>(3 * (set * c.max_tools + s) + i);
        field_of_basis(model, model.active[point.active[i]], prepare(model, prepared, point.active[i]),
                       c.field[at].share, c.field[at].own, c.field_basis + at * model.n_basis, scratch, one);
        for (std::int32_t o = 0; o < model.n_output; ++o) {
          double turned[3];
          rotate(c.field_turn + 3 * set, false, one + 3 * o, turned);
          for (int k = 0; k < 3; ++k) field[3 * o + k] += turned[k];
        }
      }
    }
  }
}

}  // namespace PHN_RUNTIME
