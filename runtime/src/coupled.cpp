#include "coupled.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "small_matrices.hpp"

namespace phynness::runtime {
namespace {

/// Changes of p this small against the displacements count as none.
constexpr double settled_change = 1e-9;
constexpr std::int32_t most_iterations = 40;
constexpr double shortest_step = 1e-3;

/// A displaced tool's stiffness counts as this part of its least at rest at least, and changes what another does to it by
/// this part of that at most (docs/decisions/coupled-tools.md).
constexpr double least_of_rest = 0.3;
constexpr double largest_shift = 0.5;

/// Where nothing settles a force is a guess: no more than this many times what all tools would feel alone.
constexpr double largest_guess = 2;

/// And what a tool contributes to it counts as this many times as much as what the points miss.
constexpr double effort = 0.1;

/// Gauss-Legendre on 0 ... 1: exact for the first six powers of the depth.
constexpr double gauss_point[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weight[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};

class Solver {
 public:
  Solver(const phn_model& model, Coupling& coupling, const double* targets)
      : _model(model), _c(coupling), _targets(targets) {}

  CoupledResult run() {
    double far = 0;
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      prepare(s);
      far = std::fmax(far, length(_targets + 3 * s));
    }
    CoupledResult result = {};
    double alone = 0;  // what the tools would feel one by one
    if (_c.n_tools > 1) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        for (int k = 0; k < 3; ++k) _c.point[s].own[k] = _targets[3 * s + k];
        pull(s);
        alone += length(_c.point[s].force);
        for (double& k : _c.point[s].own) k = 0;
      }
      result.iterations = find_own(far);
    } else {
      for (int k = 0; k < 3; ++k) _c.point[0].own[k] = _targets[k];
      respond();
    }
    result.residual = miss();
    result.settled = result.residual <= 10 * settled_change * far;
    if (!result.settled) guess();
    for (std::int32_t s = 0; !result.settled && s < _c.n_tools; ++s) limit_force(s, largest_guess * alone);
    // The fields lack what the tools do to each other's; the undeformed body makes up for it.
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) _c.shift[i] = 0;
    miss();
    if (correct()) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) add_field(s, _c.right + 3 * s);
      result.residual = miss();
    }
    if (!finite()) return give_up(far);
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const HeldPoint& point = _c.point[t];
      result.energy += point.energy + energy_of_nodes(point);
      for (int k = 0; k < 3; ++k) result.energy += point.force[k] * (_targets[3 * t + k] - point.own[k]) / 2;
    }
    if (!has_energy(_model)) result.energy = 0;
    return result;
  }

 private:
  const ActiveNode& node(const HeldPoint& point, std::int32_t i) const { return _model.active[point.active[i]]; }
  std::size_t at(std::int32_t t, std::int32_t s, std::int32_t i) const {
    return 3 * (static_cast<std::size_t>(t) * static_cast<std::size_t>(_c.max_tools) + static_cast<std::size_t>(s)) +
           static_cast<std::size_t>(i);
  }
  std::size_t pair(std::int32_t t, std::int32_t s) const { return 3 * at(t, s, 0); }
  double* gradient_at_rest(std::int32_t s, std::int32_t i) const {
    return _c.rest_gradient + 3 * static_cast<std::size_t>(3 * s + i) * _model.n_basis;
  }
  double* node_basis(std::int32_t s, std::int32_t i) const {
    return _c.node_basis + static_cast<std::size_t>(3 * s + i) * _model.n_basis;
  }

  /// Derivative of a local response at rest. @param response 3 x 3
  void rest_response(const LocalResponse& local, std::int32_t n, const double* gradient, double* response) const {
    for (int k = 0; k < 3; ++k) {
      const double unit[3] = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
      double u[3];
      local_displacement(local, 0, unit, n, gradient + k * n, u);
      for (int l = 0; l < 3; ++l) response[3 * l + k] = u[l];
    }
  }

  /// Responses of all tools at their p.
  void respond() {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      take_field(s);
      pull(s);
    }
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) _c.shift[i] = 0;
    if (!bends()) return;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      find_compliance(t, _c.compliance);
      for (std::int32_t s = 0; s < _c.n_tools; ++s) add_shift(t, s);
    }
  }

  /// What several tools cause themselves: the p that together give the targets. Broyden's method from the undeformed body's
  /// derivatives; a step that makes it worse is taken back and quartered. @return iterations
  std::int32_t find_own(double far) {
    const std::int32_t n = 3 * _c.n_tools;
    if (bends()) {
      for (std::int32_t t = 0; t < _c.n_tools; ++t) find_compliance(t, _c.rest_compliance);
    }
    set_rest_matrix();
    for (std::int32_t i = 0; i < n * n; ++i) _c.inverse[i] = i % (n + 1) == 0 ? 1 : 0;
    if (!solve_dense(_c.matrix, n, _c.inverse, n)) {
      for (std::int32_t i = 0; i < n * n; ++i) _c.inverse[i] = i % (n + 1) == 0 ? 1 : 0;
    }
    respond();
    double least = miss(), step = 1;
    std::int32_t iteration = 0;
    for (; iteration < most_iterations && step > shortest_step && least > settled_change * far; ++iteration) {
      for (std::int32_t i = 0; i < n; ++i) {
        double sum = 0;
        for (std::int32_t j = 0; j < n; ++j) sum += _c.inverse[i * n + j] * _c.right[j];
        _c.correction[i] = step * sum;
        _c.best[i] = _c.point[i / 3].own[i % 3];
        _c.before[i] = _c.right[i];
        _c.point[i / 3].own[i % 3] += _c.correction[i];
      }
      respond();
      const double now = miss();
      update_inverse(n);
      if (now < least) {
        least = now;
        step = std::fmin(1.0, 2 * step);
        continue;
      }
      step /= 4;
      for (std::int32_t i = 0; i < n; ++i) {
        _c.point[i / 3].own[i % 3] = _c.best[i];
        _c.right[i] = _c.before[i];
      }
    }
    respond();
    return iteration;
  }

  /// Broyden's update: the inverse takes the change of what was missing to the step that made it.
  void update_inverse(std::int32_t n) {
    double scale = 0;
    for (std::int32_t i = 0; i < n; ++i) {
      double moved = 0;  // the step that the inverse expects
      for (std::int32_t j = 0; j < n; ++j) moved += _c.inverse[i * n + j] * (_c.before[j] - _c.right[j]);
      _c.matrix[i] = moved;
      scale += _c.correction[i] * moved;
    }
    double square = 0;
    for (std::int32_t i = 0; i < n; ++i) square += _c.correction[i] * _c.correction[i];
    if (!(std::fabs(scale) > 1e-3 * square)) return;
    for (std::int32_t j = 0; j < n; ++j) {
      double row = 0;
      for (std::int32_t i = 0; i < n; ++i) row += _c.correction[i] * _c.inverse[i * n + j];
      _c.matrix[n + j] = row / scale;
    }
    for (std::int32_t i = 0; i < n; ++i) {
      const double left = _c.correction[i] - _c.matrix[i];
      for (std::int32_t j = 0; j < n; ++j) _c.inverse[i * n + j] += left * _c.matrix[n + j];
    }
  }

  /// Everything about a tool that does not depend on its displacement.
  void prepare(std::int32_t s) {
    HeldPoint& point = _c.point[s];
    double compliance[3][9], between[3][3][9], sum[9] = {}, inverse[9];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const ActiveNode& by = node(point, i);
      stiffness_at_rest(_model, by, point.rest_stiffness[i]);
      invert(point.rest_stiffness[i], compliance[i]);
      basis_gradient_at_rest(_model, by, gradient_at_rest(s, i), _c.kernel, _c.basis);
      const std::int32_t n = basis_size(_model, by);
      for (std::int32_t j = 0; j < point.n_nodes; ++j) {
        const double one = 1;
        prepare_local(_model, by, 1, &node(point, j).output, &one, _c.pair);
        rest_response(_c.pair, n, gradient_at_rest(s, i), between[j][i]);
        double moved[9];
        multiply_matrices(between[j][i], compliance[i], moved);
        for (int k = 0; k < 9; ++k) sum[k] += point.weight[j] * point.weight[i] * moved[k];
      }
      for (std::int32_t t = 0; t < _c.n_tools; ++t) {
        const HeldPoint& other = _c.point[t];
        std::int32_t vertex[3] = {-1, -1, -1};
        for (std::int32_t j = 0; j < other.n_nodes; ++j) vertex[j] = node(other, j).output;
        LocalResponse& local = _c.local[at(t, s, i)];
        prepare_local(_model, by, other.n_nodes, vertex, other.weight, local);
        rest_response(local, n, gradient_at_rest(s, i), _c.rest_response + 9 * at(t, s, i));
      }
    }
    invert(sum, inverse);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) point.stiffness[3 * r + c] = (inverse[3 * r + c] + inverse[3 * c + r]) / 2;
    }
    double values[9], vectors[9];
    for (int k = 0; k < 9; ++k) values[k] = point.stiffness[k];
    diagonalize(values, vectors);
    point.least_stiffness = std::fmax(std::fmin(values[0], std::fmin(values[4], values[8])),
                                      1e-3 * (std::fabs(values[0]) + std::fabs(values[4]) + std::fabs(values[8])));
    for (double& k : point.own) k = 0;
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      multiply_matrices(compliance[i], inverse, point.contribution[i]);
      for (double& q : point.contribution[i]) q *= point.weight[i];
    }
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      for (double& m : point.reach[i]) m = 0;
      for (std::int32_t j = 0; j < point.n_nodes; ++j) {
        double part[9];
        multiply_matrices(between[i][j], point.contribution[j], part);
        for (int k = 0; k < 9; ++k) point.reach[i][k] += part[k];
      }
      const double square = inner_product(point.reach[i], point.reach[i]);
      point.share[i] = square > 0 ? inner_product(point.contribution[i], point.reach[i]) / square : 0;
    }
  }

  /// Contributions of tool s's nodes: node i's response through e_i, scaled to q_i; what is missing at the tool's own
  /// point is added as the undeformed body has it.
  void take_field(std::int32_t s) {
    HeldPoint& point = _c.point[s];
    double r[3] = {point.own[0], point.own[1], point.own[2]};
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const std::int32_t n = basis_size(_model, node(point, i));
      double q[3], e[3], left[3], u[3];
      multiply(point.contribution[i], point.own, q);
      multiply(point.reach[i], point.own, e);
      const double square = dot(e, e), share = square > 0 ? dot(q, e) / square : 0;
      for (int k = 0; k < 3; ++k) left[k] = q[k] - share * e[k];
      basis_of(_model, node(point, i), e, _c.basis, _c.kernel);
      const double* gradient = gradient_at_rest(s, i);
      double* basis = node_basis(s, i);
      for (std::int32_t j = 0; j < n; ++j)
        basis[j] = share * _c.basis[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
      point.node_share[i] = share;
      for (int k = 0; k < 3; ++k) point.node_own[i][k] = q[k];
      local_displacement(_c.local[at(s, s, i)], share, q, n, basis, u);
      for (int k = 0; k < 3; ++k) r[k] -= u[k];
    }
    add_field(s, r);
  }

  /// Moves tool s's point by r as the undeformed body does.
  void add_field(std::int32_t s, const double* r) {
    HeldPoint& point = _c.point[s];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const std::int32_t n = basis_size(_model, node(point, i));
      const double* gradient = gradient_at_rest(s, i);
      double* basis = node_basis(s, i);
      double q[3];
      multiply(point.contribution[i], r, q);
      for (std::int32_t j = 0; j < n; ++j)
        basis[j] += q[0] * gradient[j] + q[1] * gradient[n + j] + q[2] * gradient[2 * n + j];
      for (int k = 0; k < 3; ++k) point.node_own[i][k] += q[k];
    }
  }

  void limit_force(std::int32_t s, double most) {
    HeldPoint& point = _c.point[s];
    const double size = length(point.force);
    for (int k = 0; k < 3 && size > most; ++k) point.force[k] *= most / size;
  }

  /// The p that miss the targets least in the undeformed body and are small themselves: tools near each other agree on what
  /// both ask for, and give up most of what sets them against each other.
  void guess() {
    const std::int32_t n = 3 * _c.n_tools;
    set_rest_matrix();
    for (std::int32_t i = 0; i < n; ++i) {
      for (std::int32_t j = 0; j < n; ++j) {
        double sum = i == j ? effort * effort : 0;
        for (std::int32_t k = 0; k < n; ++k) sum += _c.matrix[k * n + i] * _c.matrix[k * n + j];
        _c.inverse[i * n + j] = sum;
      }
      _c.correction[i] = -effort * effort * _c.point[i / 3].own[i % 3];
      for (std::int32_t k = 0; k < n; ++k) _c.correction[i] += _c.matrix[k * n + i] * _c.right[k];
    }
    if (!solve_dense(_c.inverse, n, _c.correction, 1)) return;
    for (std::int32_t i = 0; i < n; ++i) _c.point[i / 3].own[i % 3] += _c.correction[i];
    respond();
  }

  /// Displacement of tool t's point in the field of tool s.
  void displaced(std::int32_t t, std::int32_t s, double* u) const {
    const HeldPoint& point = _c.point[s];
    for (int k = 0; k < 3; ++k) u[k] = 0;
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      double by[3];
      local_displacement(_c.local[at(t, s, i)], point.node_share[i], point.node_own[i], basis_size(_model, node(point, i)),
                         node_basis(s, i), by);
      for (int k = 0; k < 3; ++k) u[k] += by[k];
    }
  }

  /// right = what the points lack of their targets. @return the largest distance
  double miss() {
    double largest = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      double* r = _c.right + 3 * t;
      for (int k = 0; k < 3; ++k) r[k] = _targets[3 * t + k] - _c.shift[3 * t + k];
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        double u[3];
        displaced(t, s, u);
        for (int k = 0; k < 3; ++k) r[k] -= u[k];
      }
      largest = std::fmax(largest, length(r));
    }
    return largest;
  }

  /// Whether tools change each other's responses: linear bodies add up, and networks have no stiffness to tell by.
  bool bends() const { return _c.n_tools > 1 && _model.family == Family::modal; }

  /// Derivative of the displacement of tool t's point by the force at tool s, when t is at its p and s is not there: by
  /// reciprocity what a force at t does to s, K_t^-1 (du_s/dp_t)^T. @param compliance  at rest or at p
  void find_compliance(std::int32_t t, double* compliance) {
    HeldPoint& point = _c.point[t];
    double stiffness[9], inverse[9], derivative[most_coupled][9] = {};
    for (int k = 0; k < 9; ++k) stiffness[k] = point.stiffness[k];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const ActiveNode& by = node(point, i);
      const std::int32_t n = basis_size(_model, by);
      double e[3], change[9], bent[9], left[9], part[9];
      multiply(point.reach[i], point.own, e);
      if (compliance == _c.rest_compliance) e[0] = e[1] = e[2] = 0;
      evaluate_stiffness(_model, by, e, change);
      for (int k = 0; k < 9; ++k) {
        change[k] = point.share[i] * (change[k] - point.rest_stiffness[i][k]);
        left[k] = point.contribution[i][k] - point.share[i] * point.reach[i][k];
      }
      multiply_matrices(change, point.reach[i], bent);
      for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) stiffness[3 * r + k] += point.reach[i][3 * l + r] * bent[3 * l + k];
        }
      }
      amplitude_gradient(_model, by, e, _c.gradient, _c.kernel);
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        if (s == t) continue;
        const LocalResponse& local = _c.local[at(s, t, i)];
        for (int r = 0; r < 3; ++r) {
          for (int k = 0; k < 3; ++k) {
            double sum = r == k ? local.direct : 0;
            for (std::int32_t j = 0; j < n; ++j) sum += local.rows[r * n + j] * _c.gradient[k * n + j];
            bent[3 * r + k] = point.share[i] * sum;
          }
        }
        multiply_matrices(bent, point.reach[i], part);
        for (int k = 0; k < 9; ++k) derivative[s][k] += part[k];
        multiply_matrices(_c.rest_response + 9 * at(s, t, i), left, part);
        for (int k = 0; k < 9; ++k) derivative[s][k] += part[k];
      }
    }
    invert_stiffness(stiffness, least_of_rest * point.least_stiffness, inverse);
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      double* between = compliance + pair(t, s);
      for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) {
          between[3 * r + k] = 0;
          for (int l = 0; l < 3; ++l) between[3 * r + k] += inverse[3 * r + l] * derivative[s][3 * k + l];
        }
      }
    }
  }

  /// What the displacement of tool t changes of what tool s does to it, at most half of that: where the change is as large
  /// as the thing itself, the next term of the series would be too.
  void add_shift(std::int32_t t, std::int32_t s) {
    if (s == t) return;
    double change[9], shift[3], u[3];
    for (int k = 0; k < 9; ++k) change[k] = _c.compliance[pair(t, s) + k] - _c.rest_compliance[pair(t, s) + k];
    multiply(change, _c.point[s].force, shift);
    displaced(t, s, u);
    const double most = largest_shift * length(u), size = length(shift);
    const double factor = size > 0 ? most / std::sqrt(most * most + size * size) : 0;
    for (int k = 0; k < 3; ++k) _c.shift[3 * t + k] += factor * shift[k];
  }

  /// right becomes the change of the p that makes up for it in the undeformed body.
  bool correct() {
    set_rest_matrix();
    return solve_dense(_c.matrix, 3 * _c.n_tools, _c.right, 1);
  }

  /// Derivatives of the points' displacements by the p in the undeformed body.
  void set_rest_matrix() {
    const std::int32_t n = 3 * _c.n_tools;
    for (std::int32_t k = 0; k < n * n; ++k) _c.matrix[k] = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
          double product[9];
          multiply_matrices(_c.rest_response + 9 * at(t, s, i), _c.point[s].contribution[i], product);
          for (int k = 0; k < 9; ++k) _c.matrix[(3 * t + k / 3) * n + 3 * s + k % 3] += product[k];
        }
      }
    }
  }

  /// sum_i s_i E_i(e_i) of (p), 0 where there is none.
  double energy_of_nodes(const HeldPoint& point) const {
    double energy = 0;
    for (std::int32_t i = 0; i < point.n_nodes && has_energy(_model); ++i) {
      double e[3];
      multiply(point.reach[i], point.own, e);
      energy += point.share[i] * evaluate_energy(_model, node(point, i), e);
    }
    return energy;
  }

  /// Force and energy of tool s at its p, the force as gradient of
  ///   p . A p / 2 + sum_i s_i [E_i(e_i) - e_i . K_i e_i / 2] - sum_g w_g / x_g psi(x_g p),
  ///   psi(p) = sum_i s_i A p . z_i(M_i p),  z_i(e) = u_i(e) - u_i'(0) e at the point.
  /// the energy without the E_i.
  void pull(std::int32_t s) {
    HeldPoint& point = _c.point[s];
    double linear[3];
    multiply(point.stiffness, point.own, linear);
    double energy = dot(linear, point.own) / 2;
    for (int k = 0; k < 3; ++k) point.force[k] = linear[k];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const ActiveNode& by = node(point, i);
      double e[3], f[3], ke[3], pulled[3];
      multiply(point.reach[i], point.own, e);
      evaluate_force(_model, by, e, f);
      multiply(point.rest_stiffness[i], e, ke);
      for (int k = 0; k < 3; ++k) f[k] -= ke[k];
      multiply_transposed(point.reach[i], f, pulled);
      for (int k = 0; k < 3; ++k) point.force[k] += point.share[i] * pulled[k];
      energy -= point.share[i] * dot(ke, e) / 2;
      // A node alone follows the tool itself: nothing is left to couple.
      for (int g = 0; g < 3 && point.n_nodes > 1; ++g)
        energy -= pull_of_coupling(s, i, e, linear, gauss_point[g], gauss_weight[g]);
    }
    point.energy = energy;
  }

  /// The part of node i in psi, at x p. @return w / x times it
  double pull_of_coupling(std::int32_t s, std::int32_t i, const double* e, const double* linear, double x, double w) {
    HeldPoint& point = _c.point[s];
    const ActiveNode& by = node(point, i);
    const LocalResponse& local = _c.local[at(s, s, i)];
    const double *rest = _c.rest_response + 9 * at(s, s, i), *rest_gradient = gradient_at_rest(s, i);
    const std::int32_t n = basis_size(_model, by);
    const double there[3] = {x * e[0], x * e[1], x * e[2]};
    basis_and_gradient(_model, by, there, _c.basis, _c.gradient, _c.kernel);
    double z[3], expected[3], back[3] = {0, 0, 0}, pulled[3], reached[3];
    local_displacement(local, 1, there, n, _c.basis, z);
    multiply(rest, there, expected);
    for (int k = 0; k < 3; ++k) z[k] -= expected[k];
    // Transposed derivative of z by e, times A p.
    for (int r = 0; r < 3; ++r) {
      const double* row = local.rows + r * n;
      for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (std::int32_t j = 0; j < n; ++j) sum += row[j] * (_c.gradient[k * n + j] - rest_gradient[k * n + j]);
        back[k] += x * linear[r] * sum;
      }
    }
    multiply(point.stiffness, z, pulled);
    multiply_transposed(point.reach[i], back, reached);
    for (int k = 0; k < 3; ++k) point.force[k] -= w * point.share[i] * (pulled[k] + reached[k]);
    return w * point.share[i] * dot(linear, z);
  }

  bool finite() const {
    bool all = true;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const HeldPoint& point = _c.point[t];
      for (int k = 0; k < 3; ++k) all = all && std::isfinite(point.force[k]) && std::isfinite(point.own[k]);
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        for (int k = 0; k < 3; ++k) all = all && std::isfinite(point.node_own[i][k]);
        for (std::int32_t j = 0; j < basis_size(_model, node(point, i)); ++j)
          all = all && std::isfinite(node_basis(t, i)[j]);
      }
    }
    return all;
  }

  /// Zeros: sums left the range of numbers.
  CoupledResult give_up(double far) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      HeldPoint& point = _c.point[t];
      for (int k = 0; k < 3; ++k) point.force[k] = point.own[k] = 0;
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        point.node_share[i] = 0;
        for (int k = 0; k < 3; ++k) point.node_own[i][k] = 0;
        for (std::int32_t j = 0; j < basis_size(_model, node(point, i)); ++j) node_basis(t, i)[j] = 0;
      }
    }
    return {false, far, 0, 0};
  }

  const phn_model& _model;
  Coupling& _c;
  const double* _targets;
};

}  // namespace

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  c.model = &model;
  const auto t = static_cast<std::size_t>(c.max_tools);
  const std::size_t n_locals = 3 * t * t;
  c.point = arena.take<HeldPoint>(t);
  c.local = arena.take<LocalResponse>(n_locals);
  auto* rows = arena.take<double>(3 * model.n_basis, n_locals + 1);
  for (std::size_t i = 0; c.local && rows && i < n_locals; ++i) c.local[i].rows = rows + 3 * model.n_basis * i;
  c.pair.rows = rows ? rows + 3 * model.n_basis * n_locals : nullptr;
  c.rest_response = arena.take<double>(9 * n_locals);
  c.rest_gradient = arena.take<double>(9 * t, model.n_basis);
  c.node_basis = arena.take<double>(3 * t, model.n_basis);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  c.kernel = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  c.compliance = arena.take<double>(9 * t * t);
  c.rest_compliance = arena.take<double>(9 * t * t);
  c.matrix = arena.take<double>(9 * t * t);
  c.inverse = arena.take<double>(9 * t * t);
  c.right = arena.take<double>(3 * t);
  c.shift = arena.take<double>(3 * t);
  c.before = arena.take<double>(3 * t);
  c.best = arena.take<double>(3 * t);
  c.correction = arena.take<double>(3 * t);
  return c;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const double* targets) {
  return Solver(model, coupling, targets).run();
}

void coupled_field(const phn_model& model, const Coupling& c, PreparedNodes& prepared, double* scratch, double* one,
                   double* field) {
  for (std::int32_t s = 0; s < c.n_tools; ++s) {
    const HeldPoint& point = c.point[s];
    for (std::int32_t i = 0; i < point.n_nodes; ++i) {
      const double* basis = c.node_basis + static_cast<std::size_t>(3 * s + i) * model.n_basis;
      field_of_basis(model, model.active[point.active[i]], prepare(model, prepared, point.active[i]),
                     point.node_share[i], point.node_own[i], basis, scratch, one);
      for (std::int32_t o = 0; o < 3 * model.n_output; ++o) field[o] += one[o];
    }
  }
}

}  // namespace phynness::runtime
