// Several tools of node probes. The point of each tool is a constraint. The response to one tool leaves residuals at
// the others, and their multipliers are the forces that move the points by the residuals. In each order another tool
// acts first, and the others add the residuals; the orders are combined (docs/theory.md, equation (u)).
#include <cmath>

#include "core/evaluate.hpp"
#include "tools/constraints.hpp"

namespace PHN_RUNTIME {
namespace {

/// Fraction of all tools' energies that is added to the weight of each order. With 0, the weights of two tools with
/// consistent displacements, whose residuals are 0 in both orders, would jump with their smallest difference.
constexpr double equal_part = 0.05;

/// Fraction of the surface's rotation around a point, caused by the first tool, by which the body is rotated for the
/// second tool (docs/decisions/coupled-tools.md).
constexpr double rotation_part = 0.7;

/// Nonlinearity (see nonlinearity()) at which half of the rotation is used. Linear laws, for which fields must not be
/// rotated, have 1e-6; nonlinear laws have 0.05 and more.
constexpr double half_nonlinearity = 0.005;

/// Fraction of all orders' weights below which the field of an order's residuals is not rotated. Without residuals the
/// mean of the rotations is undefined, but fields of networks have a constant part.
constexpr double smallest_rotated_part = 1e-6;

/// A point that is farther from its tool than this fraction of the largest displacement does not follow it.
constexpr double residual_tolerance = 1e-8;

/// Smallest compliance of opposing displacements of two tools, as a fraction of each tool's own compliance. Below it
/// the tools are so close that opposing displacements are followed only in part (docs/decisions/coupled-tools.md).
constexpr double smallest_eigenvalue = 0.05;

class Solver : private Constraints {
 public:
  Solver(const phn_model& model, Coupling& coupling, const Vector* targets)
      : Constraints(model, coupling), _targets(targets) {}

  CoupledResult run() {
    const std::int32_t n = _c.n_tools;
    double largest = 0;
    _c.n_sets = n > 1 && !schema::traits(_model.kind).proportional ? 1 + n : 1;
    for (std::int32_t s = 0; s < n; ++s) {
      prepare(s);
      largest = std::fmax(largest, length(_targets[s].x));
    }
    for (std::int32_t s = 0; s < n && has_rotations(); ++s) prepare_rotation(s);
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
    if (solve_correction())
      for (std::int32_t s = 0; s < n; ++s) add_at_rest(0, s, _c.correction[s], 1);
    result.residual = constraint_residual();
    result.settled = result.residual <= residual_tolerance * largest;
    if (!_model.has_energy) result.energy = 0;
    for (std::int32_t s = 0; s < n; ++s) _c.point[s].displacement = _targets[s];
    return finite() ? result : fail(largest);
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
    Vector rotation = {};
    double all = 0;
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      const Vector own = _c.point[j].compliance * _c.multiplier(i, j);
      add_at_rest(set_of(i), j, own, _c.weight[i]);
      if (j == i || !has_rotations()) continue;
      const double part = dot(_c.multiplier(i, j), own);
      rotation += part * _c.residual_rotation(i, j);
      all += part;
    }
    all += smallest_rotated_part * _sum;
    if (has_rotations()) _c.field_rotation[set_of(i)] = all > 0 ? rotation / all : Vector{};
  }

  void add_order_to_forces(std::int32_t i) {
    Vector force[most_coupled];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      const Vector& multiplier = _c.multiplier(i, j);
      _c.energy[i] += dot(_c.residual(i, j), multiplier) / 2;
      force[j] = j == i ? Vector{} : multiplier;
      if (j != i && !schema::traits(_model.kind).proportional) _c.energy[i] += nonlinear_energy(i, j, force[j]);
    }
    transpose_apply(i, force);
    force[i] += _c.single_force[i];
    for (std::int32_t j = 0; j < _c.n_tools; ++j) _c.forces[j] += _c.weight[i] * force[j];
  }

  /// Rotation vector (argument of rotated) for tool j, relative to the rotation that tool i causes at its point.
  double rotation_factor(std::int32_t i, std::int32_t j) const {
    const double area = _c.point[j].rotation_area, nonlinear = _c.point[i].nonlinearity + _c.point[j].nonlinearity;
    return area > 0 ? rotation_part / 2 / area * nonlinear / (nonlinear + 2 * half_nonlinearity * half_nonlinearity)
                    : 0;
  }

  /// The set with the field that order i leaves to the others.
  std::int32_t set_of(std::int32_t i) const { return has_rotations() ? 1 + i : 0; }

  /// Computes the residuals of order i, rotated back by the rotation that tool i causes, and their multipliers.
  void find_residuals(std::int32_t i) {
    const std::int32_t n = _c.n_tools;
    for (std::int32_t j = 0; j < n; ++j) {
      Vector &residual = _c.residual(i, j), &rotation = _c.residual_rotation(i, j);
      residual = rotation = {};
      if (j == i) continue;
      if (has_rotations()) rotation = rotation_factor(i, j) * response_at(quantity(n + j), i);
      residual = rotated_back(rotation, _targets[j] - response_at(j, i));
    }
    multiply(&_c.residual(i, 0), &_c.multiplier(i, 0));
  }

  /// Applies the chain rule from the residuals of order i, rotated back, to the displacements of all tools.
  /// @param force  derivatives by the former, 0 for tool i; replaced by derivatives by the latter
  void transpose_apply(std::int32_t i, Vector* force) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      if (j == i) continue;
      const Vector &rotation = _c.residual_rotation(i, j), &residual = _c.residual(i, j), g = force[j];
      force[j] = rotated(rotation, g);
      force[i] -= transposed_times(_c.derivative(j, i), force[j]);
      if (!has_rotations()) continue;
      const Vector change = rotation_gradient(rotation, g, rotated(rotation, residual));
      force[i] += rotation_factor(i, j) * transposed_times(_c.derivative(quantity(_c.n_tools + j), i), change);
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
      for (std::int32_t j = 0; j < n; ++j)
        if (j != i) _c.weight[i] += dot(_c.multiplier(j, i), _c.point[i].compliance * _c.multiplier(j, i));
      _sum += _c.weight[i];
    }
    for (std::int32_t i = 0; i < n; ++i) _c.weight[i] = _sum > 0 ? _c.weight[i] / _sum : 1.0 / n;
  }

  /// Adds the forces that result from the change of the weights with the displacements, so that the forces remain the
  /// gradient of the energy.
  void add_change_of_weights(double energy) {
    const std::int32_t n = _c.n_tools;
    if (!(_sum > 0)) return;
    double deviation = 0;  // of the energies of the orders from their mean
    for (std::int32_t i = 0; i < n; ++i) deviation += (_c.energy[i] - energy) / _sum;
    for (std::int32_t i = 0; i < n; ++i)
      _c.forces[i] += (deviation * equal_part * 2) * (_c.point[i].stiffness * _targets[i]);
    for (std::int32_t first = 0; first < n; ++first) {
      Vector own[most_coupled], force[most_coupled];
      for (std::int32_t i = 0; i < n; ++i) {
        const double factor = i == first ? 0 : 2 * (_c.energy[i] - energy) / _sum;
        own[i] = factor * (_c.point[i].compliance * _c.multiplier(first, i));
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
    const Vector z = point.remaining_part * _c.residual(i, j);
    const double energy = respond(j, z);
    const Vector linear = point.stiffness * z;
    multiplier += transposed_times(point.remaining_part, point.force - linear);
    add_response(set_of(i), j, _c.weight[i]);
    add_at_rest(set_of(i), j, z, -_c.weight[i]);
    return energy - dot(z, linear) / 2;
  }

  std::size_t basis_of_set() const { return static_cast<std::size_t>(_c.n_corners * _c.n_tools) * _model.n_basis; }

  void clear_field() {
    for (std::int32_t set = 0; set < _c.n_sets; ++set) {
      _c.field_rotation[set] = {};
      for (std::int32_t i = 0; i < _c.n_corners * _c.n_tools; ++i) (&_c.field(set, 0, 0))[i] = {};
      set_zero(_c.field_basis(set, 0, 0), basis_of_set());
    }
  }

  /// Adds to the field `weight` times the latest response of tool s.
  void add_response(std::int32_t set, std::int32_t s, double weight) {
    const Constraint& point = _c.point[s];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      _c.field(set, s, i).factor += weight * point.response_factor[i];
      _c.field(set, s, i).displacement += weight * point.response_displacement[i];
      add_scaled(weight, _c.response_basis(0, s, i), basis_size(_model, node(point, i)), _c.field_basis(set, s, i));
    }
  }

  /// Adds to the field `weight` times the response of the undeformed body that moves tool s's point.
  /// @param r  displacement of the point [m]
  void add_at_rest(std::int32_t set, std::int32_t s, const Vector& r, double weight) {
    for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i)
      add_rest_response(s, i, r, weight, _c.field_basis(set, s, i), _c.field(set, s, i).displacement);
  }

  /// Sets `correction` to the targets minus the displacements of the points in the field. @return the largest distance
  double constraint_residual() {
    double largest = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      _c.correction[t] = _targets[t];
      for (std::int32_t set = 0; set < _c.n_sets; ++set) {
        Vector sum = {};
        for (std::int32_t s = 0; s < _c.n_tools; ++s) {
          const Constraint& point = _c.point[s];
          for (std::int32_t i = 0; i < point.n_nodes; ++i)
            sum += displacement_of(_c.response(t, s, i), _c.field(set, s, i).factor, _c.field(set, s, i).displacement,
                                   basis_size(_model, node(point, i)), _c.field_basis(set, s, i));
        }
        _c.correction[t] -= rotated(_c.field_rotation[set], sum);
      }
      largest = std::fmax(largest, length(_c.correction[t].x));
    }
    return largest;
  }

  /// Whether forces and field are finite.
  bool finite() const {
    bool all = true;
    for (std::int32_t t = 0; t < _c.n_tools; ++t)
      all = all && is_finite(_c.point[t].force) && is_finite(_c.point[t].displacement);
    for (std::int32_t set = 0; set < _c.n_sets; ++set) {
      all = all && is_finite(_c.field_rotation[set]);
      for (std::int32_t i = 0; i < _c.n_corners * _c.n_tools; ++i)
        all = all && is_finite((&_c.field(set, 0, 0))[i].displacement);
      all = all && all_finite(_c.field_basis(set, 0, 0), basis_of_set());
    }
    return all;
  }

  /// Computes, from the derivatives of the points by the p in the undeformed body, the forces that move the points by
  /// given displacements, and for each tool the part of its displacement that remains when the others hold their
  /// points. Compliances are scaled to 1 for each tool alone. An almost singular compliance means that tools are too
  /// close together to be distinguished; there the inverse goes to 0 with the eigenvalue instead of to infinity.
  void find_stiffness() {
    const std::int32_t n = 3 * _c.n_tools;
    const MatrixView<double> work{_c.work, n};
    for (std::int32_t t = 0; t < _c.n_tools; ++t)
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Matrix scaled = _c.point[t].stiffness_root * rest_block(t, s) * _c.point[s].compliance_root;
        for (int k = 0; k < 9; ++k) work(3 * t + k / 3, 3 * s + k % 3) = scaled.a[k];
      }
    for (std::int32_t i = 0; i < n; ++i)
      for (std::int32_t j = 0; j < i; ++j) work(i, j) = work(j, i) = (work(i, j) + work(j, i)) / 2;
    diagonalize(_c.work, n, _c.vectors);
    double least = work(0, 0);
    for (std::int32_t e = 1; e < n; ++e) least = std::fmin(least, work(e, e));
    _is_regular = least >= smallest_eigenvalue;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      Constraint& point = _c.point[t];
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Matrix scaled = inverse_block(t, s);
        _c.stiffness(t, s) = point.stiffness_root * scaled * _c.point[s].stiffness_root;
        // Other tools can only stiffen a point.
        if (s == t)
          point.remaining_part = point.compliance_root * inverse_of_stiffness(scaled, 1) * point.stiffness_root;
      }
    }
  }

  /// Block (t, s) of the inverse of the scaled compliances. @pre they are diagonalized
  Matrix inverse_block(std::int32_t t, std::int32_t s) const {
    const std::int32_t n = 3 * _c.n_tools;
    const MatrixView<double> work{_c.work, n}, vectors{_c.vectors, n};
    Matrix block = {};
    for (std::int32_t e = 0; e < n; ++e) {
      const double value = work(e, e);
      const double inverse = value >= smallest_eigenvalue
                                 ? 1 / value
                                 : std::fmax(value, 0.0) / (smallest_eigenvalue * smallest_eigenvalue);
      for (int k = 0; k < 9; ++k) block.a[k] += vectors(3 * t + k / 3, e) * inverse * vectors(3 * s + k % 3, e);
    }
    return block;
  }

  /// Forces of the undeformed body at all points for given displacements of the points.
  void multiply(const Vector* moved, Vector* multiplier) const {
    for (std::int32_t j = 0; j < _c.n_tools; ++j) {
      multiplier[j] = {};
      for (std::int32_t s = 0; s < _c.n_tools; ++s) multiplier[j] += _c.stiffness(j, s) * moved[s];
    }
  }

  /// Replaces `correction` by the change of the p that causes it in the undeformed body, as far as the tools can be
  /// distinguished. @return false if the system is singular
  bool solve_correction() {
    if (!_is_regular) {
      multiply(_c.correction, _c.forces);
      for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.correction[t] = _c.point[t].compliance * _c.forces[t];
      return true;
    }
    if (_c.n_tools == 1) return true;
    const std::int32_t n = 3 * _c.n_tools;
    double right[3 * most_coupled];
    for (std::int32_t i = 0; i < n; ++i) right[i] = _c.correction[i / 3][i % 3];
    for (std::int32_t i = 0; i < n * n; ++i) _c.work[i] = _c.rest_matrix[i];
    if (!solve_dense({_c.work, n}, right)) return false;
    for (std::int32_t i = 0; i < n; ++i) _c.correction[i / 3][i % 3] = right[i];
    return true;
  }

  /// Sets all results to zero after an overflow of sums.
  CoupledResult fail(double largest) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.point[t].force = _c.point[t].displacement = {};
    clear_field();
    return {false, largest, 0};
  }

  const Vector* _targets;
  double _sum = 0;          ///< of the weights before normalization
  bool _is_regular = true;  ///< all tools can be distinguished
};

}  // namespace

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets) {
  return Solver(model, coupling, targets).run();
}

}  // namespace PHN_RUNTIME
