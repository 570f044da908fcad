#include "coupled.hpp"

#include <cmath>

#include "evaluate.hpp"

namespace phynness::runtime {
namespace {

/// Changes of e this small against the displacements count as none.
constexpr double settled_change = 1e-9;
/// Shorter secants, in max_displacement_m, are those at rest: their difference would be rounding, and networks, which
/// are not 0 at rest, would divide by nothing.
constexpr double shortest_secant = 1e-4;
/// Plain substitution gains a digit in one or two iterations; where it swings, beside a snap, half steps follow.
constexpr std::int32_t plain_iterations = 20, damped_iterations = 20;

void multiply(const double* a, const double* x, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
}

void multiply_matrices(const double* a, const double* b, double* c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  }
}

/// Inverse of a 3 x 3 matrix, of one a little stiffer if it is close to singular.
void invert(const double* given, double* inverse) {
  double a[9], size = 0;
  for (int i = 0; i < 9; ++i) {
    a[i] = given[i];
    size = std::fmax(size, std::fabs(a[i]));
  }
  for (double shift = 1e-3;; shift *= 10) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
        inverse[3 * j + i] = a[3 * p + r] * a[3 * q + s] - a[3 * p + s] * a[3 * q + r];
      }
    }
    const double determinant = a[0] * inverse[0] + a[1] * inverse[3] + a[2] * inverse[6];
    if (std::fabs(determinant) > 1e-9 * size * size * size || !(size > 0) || shift > 1e3) {
      const double factor = determinant != 0 ? 1 / determinant : 0;
      for (int i = 0; i < 9; ++i) inverse[i] *= factor;
      return;
    }
    for (int i = 0; i < 3; ++i) a[4 * i] = given[4 * i] + shift * size;
  }
}

/// Gaussian elimination with partial pivoting; the solution replaces the n_right right-hand sides, row by row.
bool solve_dense(double* a, std::int32_t n, double* right, std::int32_t n_right) {
  double size = 0;
  for (std::int32_t i = 0; i < n * n; ++i) size = std::fmax(size, std::fabs(a[i]));
  for (std::int32_t k = 0; k < n; ++k) {
    std::int32_t pivot = k;
    for (std::int32_t i = k + 1; i < n; ++i) {
      if (std::fabs(a[i * n + k]) > std::fabs(a[pivot * n + k])) pivot = i;
    }
    if (!(std::fabs(a[pivot * n + k]) > 1e-13 * size)) return false;
    const auto swap_rows = [&](double* rows, std::int32_t width) {
      for (std::int32_t j = 0; j < width && pivot != k; ++j) {
        const double kept = rows[k * width + j];
        rows[k * width + j] = rows[pivot * width + j];
        rows[pivot * width + j] = kept;
      }
    };
    swap_rows(a, n);
    swap_rows(right, n_right);
    for (std::int32_t i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] / a[k * n + k];
      for (std::int32_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
      for (std::int32_t j = 0; j < n_right; ++j) right[i * n_right + j] -= factor * right[k * n_right + j];
    }
  }
  for (std::int32_t k = n - 1; k >= 0; --k) {
    for (std::int32_t j = 0; j < n_right; ++j) {
      double sum = right[k * n_right + j];
      for (std::int32_t i = k + 1; i < n; ++i) sum -= a[k * n + i] * right[i * n_right + j];
      right[k * n_right + j] = sum / a[k * n + k];
    }
  }
  return true;
}

/// q = share e + left, the two at right angles.
double share_of(const double* q, const double* e, double* left) {
  const double square = dot(e, e), share = square > 0 ? dot(q, e) / square : 0;
  for (int k = 0; k < 3; ++k) left[k] = q[k] - share * e[k];
  return share;
}

/// basis = share basis(e) + gradient at rest . left: what belongs to the contribution q of a node.
double combined_basis(const double* q, const double* e, std::int32_t n, const double* at_e, const double* gradient,
                      double* basis) {
  double left[3];
  const double share = share_of(q, e, left);
  for (std::int32_t j = 0; j < n; ++j)
    basis[j] = share * at_e[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
  return share;
}

class Solver {
 public:
  Solver(const phn_model& model, Coupling& coupling, const double* targets)
      : _model(model), _c(coupling), _targets(targets) {}

  CoupledResult run() {
    prepare();
    bool settled = false;
    std::int32_t n = 0;
    for (; n < plain_iterations + damped_iterations && !settled; ++n) {
      if (!substitute()) break;
      settled = move_reach(n < plain_iterations ? 1.0 : 0.5);
    }
    if (!settled) substitute();  // points are where they were put, whatever else does not fit
    return result(settled, n);
  }

 private:
  std::size_t pair(std::int32_t at, std::int32_t by) const {
    return static_cast<std::size_t>(at) * static_cast<std::size_t>(_c.n_nodes) + static_cast<std::size_t>(by);
  }
  const ActiveNode& node(std::int32_t i) const { return _model.active[_c.active[i]]; }
  double weight(std::int32_t tool, std::int32_t i) const { return _c.weight[pair(tool, i)]; }
  double* basis(std::int32_t i) const { return _c.basis + static_cast<std::size_t>(i) * _model.n_basis; }
  double* gradient(std::int32_t i) const {
    return _c.rest_gradient + 3 * static_cast<std::size_t>(i) * _model.n_basis;
  }

  void prepare() {
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      stiffness_at_rest(_model, node(i), _c.rest_stiffness + 9 * i);
      basis_gradient_at_rest(_model, node(i), gradient(i), _c.kernel);
      const std::int32_t n = basis_size(_model, node(i));
      double sum = 0;
      for (int k = 0; k < 3; ++k) _c.reach[3 * i + k] = _c.displacement[3 * i + k] = 0;
      for (std::int32_t t = 0; t < _c.n_tools; ++t) {
        sum += weight(t, i);
        for (int k = 0; k < 3; ++k) _c.reach[3 * i + k] += weight(t, i) * _targets[3 * t + k];
      }
      for (int k = 0; k < 3; ++k) _c.reach[3 * i + k] /= sum;
      for (std::int32_t j = 0; j < _c.n_nodes; ++j) {
        LocalResponse& local = _c.local[pair(j, i)];
        prepare_local(_model, node(i), node(j).output, local);
        double* response = _c.rest_response + 9 * pair(j, i);
        for (int k = 0; k < 3; ++k) {
          const double unit[3] = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
          double u[3];
          local_displacement(local, 0, unit, n, gradient(i) + k * n, u);
          for (int l = 0; l < 3; ++l) response[3 * l + k] = u[l];
        }
        bool& together = _c.together[pair(j, i)] = false;
        for (std::int32_t t = 0; t < _c.n_tools; ++t) together = together || (weight(t, i) > 0 && weight(t, j) > 0);
      }
    }
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) _c.force[i] = 0;
  }

  /// Secants of node i through e_i: the symmetric matrix nearest to the rest stiffness that gives the force at e_i
  /// (Powell, in Nonlinear Programming, 1970), and the rest response with the displacement at e_i in place of its
  /// product with e_i (Broyden 1965, doi 10.1090/S0025-5718-1965-0198670-6).
  void take_secants(std::int32_t i) {
    const double *e = _c.reach + 3 * i, *k0 = _c.rest_stiffness + 9 * i;
    basis_of(_model, node(i), e, basis(i), _c.kernel);
    const double shortest = shortest_secant * _model.max_displacement;
    const double factor = 1 / std::fmax(dot(e, e), shortest * shortest);
    double f[3], linear[3], secant[9];
    evaluate_force(_model, node(i), e, f);
    multiply(k0, e, linear);
    const double y[3] = {f[0] - linear[0], f[1] - linear[1], f[2] - linear[2]};
    const double along = dot(y, e) * factor;
    for (int r = 0; r < 3; ++r) {
      for (int s = 0; s < 3; ++s)
        secant[3 * r + s] = k0[3 * r + s] + factor * (y[r] * e[s] + e[r] * y[s] - along * e[r] * e[s]);
    }
    invert(secant, _c.compliance + 9 * i);
    for (std::int32_t j = 0; j < _c.n_nodes; ++j) {
      const double* at_rest = _c.rest_response + 9 * pair(j, i);
      double* response = _c.response + 9 * pair(j, i);
      double u[3], rest[3];
      local_displacement(_c.local[pair(j, i)], 1, e, basis_size(_model, node(i)), basis(i), u);
      multiply(at_rest, e, rest);
      for (int r = 0; r < 3; ++r) {
        for (int s = 0; s < 3; ++s) response[3 * r + s] = at_rest[3 * r + s] + factor * (u[r] - rest[r]) * e[s];
      }
    }
  }

  /// Forces and contributions with the secants through the present e: q_i = compliance_i sum_t w_ti force_t such that
  /// sum_ji w_tj response_ji q_i = target_t.
  bool substitute() {
    const std::int32_t n = 3 * _c.n_tools;
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) take_secants(i);
    for (std::int32_t k = 0; k < n * n; ++k) _c.matrix[k] = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (int k = 0; k < 3; ++k) _c.right[3 * t + k] = _targets[3 * t + k];
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        double moved[9] = {}, product[9];
        for (std::int32_t j = 0; j < _c.n_nodes; ++j) {
          for (int k = 0; k < 9; ++k) moved[k] += weight(t, j) * _c.response[9 * pair(j, i) + static_cast<std::size_t>(k)];
        }
        multiply_matrices(moved, _c.compliance + 9 * i, product);
        for (std::int32_t s = 0; s < _c.n_tools; ++s) {
          for (int k = 0; k < 9; ++k) _c.matrix[(3 * t + k / 3) * n + 3 * s + k % 3] += weight(s, i) * product[k];
        }
      }
    }
    if (!solve_dense(_c.matrix, n, _c.right, 1)) return false;
    for (std::int32_t i = 0; i < n; ++i) _c.force[i] = _c.right[i];
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      double f[3] = {0, 0, 0};
      for (std::int32_t t = 0; t < _c.n_tools; ++t) {
        for (int k = 0; k < 3; ++k) f[k] += weight(t, i) * _c.force[3 * t + k];
      }
      multiply(_c.compliance + 9 * i, f, _c.displacement + 3 * i);
    }
    return true;
  }

  /// e_i becomes how far node i is moved by all nodes that some tool holds together with it; what the others do to it
  /// carries its surroundings along and strains them little. Stays as it is where it settled, with the secants through
  /// it, so that points are where they were put.
  bool move_reach(double step) {
    double change = 0, far = 0;
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      double* moves = _c.moves + 3 * i;
      for (int k = 0; k < 3; ++k) moves[k] = 0;
      for (std::int32_t j = 0; j < _c.n_nodes; ++j) {
        double u[3];
        multiply(_c.response + 9 * pair(i, j), _c.displacement + 3 * j, u);
        for (int k = 0; k < 3 && _c.together[pair(i, j)]; ++k) moves[k] += u[k];
      }
      const double* e = _c.reach + 3 * i;
      const double apart[3] = {moves[0] - e[0], moves[1] - e[1], moves[2] - e[2]};
      change = std::fmax(change, length(apart));
      far = std::fmax(far, length(moves));
    }
    if (change <= settled_change * far) return true;
    if (!std::isfinite(change)) return false;
    for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i) _c.reach[i] += step * (_c.moves[i] - _c.reach[i]);
    return false;
  }

  CoupledResult result(bool settled, std::int32_t iterations) {
    bool finite = true;
    for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i)
      finite = finite && std::isfinite(_c.displacement[i]) && std::isfinite(_c.reach[i]);
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) finite = finite && std::isfinite(_c.force[i]);
    for (std::int32_t i = 0; i < 3 * _c.n_nodes && !finite; ++i) _c.displacement[i] = _c.reach[i] = 0;
    for (std::int32_t i = 0; i < 3 * _c.n_tools && !finite; ++i) _c.force[i] = 0;
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) basis_of(_model, node(i), _c.reach + 3 * i, basis(i), _c.kernel);
    CoupledResult result = {settled && finite, 0, 0, iterations};
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      double apart[3];
      for (int k = 0; k < 3; ++k) apart[k] = -_targets[3 * t + k];
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        for (std::int32_t j = 0; j < _c.n_nodes; ++j) {
          double u[3];
          contribution(j, i, u);
          for (int k = 0; k < 3; ++k) apart[k] += weight(t, j) * u[k];
        }
      }
      result.residual = std::fmax(result.residual, length(apart));
    }
    if (has_energy(_model) && finite) result.energy = energy();
    return result;
  }

  /// What node i does to node j.
  void contribution(std::int32_t j, std::int32_t i, double* u) {
    const double* q = _c.displacement + 3 * i;
    const std::int32_t n = basis_size(_model, node(i));
    const double share = combined_basis(q, _c.reach + 3 * i, n, basis(i), gradient(i), _c.combined);
    local_displacement(_c.local[pair(j, i)], share, q, n, _c.combined, u);
  }

  /// Half of force times displacement, a linear body's, and each node's part of what its response stores beyond that.
  double energy() {
    double sum = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) sum += dot(_c.force + 3 * t, _targets + 3 * t) / 2;
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      const double *e = _c.reach + 3 * i, *q = _c.displacement + 3 * i;
      double f[3], left[3];
      evaluate_force(_model, node(i), e, f);
      const double share = share_of(q, e, left);
      sum += share * (evaluate_energy(_model, node(i), e) - dot(f, e) / 2);
    }
    return sum;
  }

  const phn_model& _model;
  Coupling& _c;
  const double* _targets;
};

}  // namespace

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  const auto t = static_cast<std::size_t>(c.max_tools), n = 3 * t;
  c.active = arena.take<std::int32_t>(n);
  c.together = arena.take<bool>(n * n);
  c.weight = arena.take<double>(t * n);
  c.displacement = arena.take<double>(3 * n);
  c.reach = arena.take<double>(3 * n);
  c.moves = arena.take<double>(3 * n);
  c.force = arena.take<double>(3 * t);
  c.rest_stiffness = arena.take<double>(9 * n);
  c.compliance = arena.take<double>(9 * n);
  c.rest_gradient = arena.take<double>(3 * n * model.n_basis);
  c.basis = arena.take<double>(n * model.n_basis);
  c.combined = arena.take<double>(model.n_basis);
  c.local = arena.take<LocalResponse>(n * n);
  auto* rows = arena.take<double>(3 * model.n_basis * n * n);
  for (std::size_t i = 0; c.local && rows && i < n * n; ++i) c.local[i].rows = rows + 3 * model.n_basis * i;
  c.rest_response = arena.take<double>(9 * n * n);
  c.response = arena.take<double>(9 * n * n);
  c.matrix = arena.take<double>(n * n);
  c.right = arena.take<double>(n);
  c.kernel = arena.take<double>(static_cast<std::size_t>(model.shared.n_centers) + 3);
  return c;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& c, std::int32_t n_tools, std::int32_t n_nodes,
                            const std::int32_t* active, const double* weight, const double* targets) {
  c.n_tools = n_tools;
  c.n_nodes = n_nodes;
  for (std::int32_t i = 0; i < n_nodes; ++i) c.active[i] = active[i];
  for (std::int32_t i = 0; i < n_tools * n_nodes; ++i) c.weight[i] = weight[i];
  return Solver(model, c, targets).run();
}

void coupled_field(const phn_model& model, const Coupling& c, PreparedNodes& prepared, double* scratch, double* one,
                   double* field) {
  for (std::int32_t i = 0; i < c.n_nodes; ++i) {
    const ActiveNode& node = model.active[c.active[i]];
    const auto at = static_cast<std::size_t>(i) * model.n_basis;
    const double* q = c.displacement + 3 * i;
    const double share = combined_basis(q, c.reach + 3 * i, basis_size(model, node), c.basis + at,
                                        c.rest_gradient + 3 * at, c.combined);
    field_of_basis(model, node, touch(model, prepared, c.active[i]), share, q, c.combined, scratch, one);
    for (std::int32_t o = 0; o < 3 * model.n_output; ++o) field[o] += one[o];
  }
}

}  // namespace phynness::runtime
