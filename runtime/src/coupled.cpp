#include "coupled.hpp"

#include <cmath>

#include "evaluate.hpp"

namespace phynness::runtime {
namespace {

/// Newton's method is quadratic: a step this small against the displacements leaves only rounding.
constexpr double settled_step = 1e-8;
/// Iterations from where the last call ended; then, from rest, of each of so many steps; then of the fallback.
constexpr std::int32_t warm_iterations = 12, cold_steps = 4, cold_iterations = 8, fallback_iterations = 12;
/// No node moves further in one iteration, in max_displacement_m: responses bend on that scale.
constexpr double longest_step = 0.25;

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

class Solver {
 public:
  Solver(const phn_model& model, Coupling& coupling, const double* targets)
      : _model(model), _c(coupling), _targets(targets) {}

  CoupledResult run(const SurfacePoint* points) {
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t i = 0; i < _c.n_nodes; ++i)
        prepare_local(_model, node(i), 3, points[t].vertex, points[t].weight, _c.local[at(t, i)]);
    }
    bool settled = iterate(1, warm_iterations);
    if (!settled) {
      set_to_rest();
      for (std::int32_t s = 1; s <= cold_steps; ++s)
        settled = iterate(static_cast<double>(s) / cold_steps, cold_iterations);
    }
    if (!settled) fall_back();
    return result(settled);
  }

 private:
  std::size_t at(std::int32_t tool, std::int32_t i) const {
    return static_cast<std::size_t>(tool) * static_cast<std::size_t>(_c.n_nodes) + static_cast<std::size_t>(i);
  }
  const ActiveNode& node(std::int32_t i) const { return _model.active[_c.active[i]]; }
  double weight(std::int32_t tool, std::int32_t i) const { return _c.weight[at(tool, i)]; }

  void set_to_rest() {
    for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i) _c.displacement[i] = 0;
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) _c.force[i] = 0;
  }

  void forces() {
    for (std::int32_t i = 0; i < _c.n_nodes; ++i)
      evaluate_force(_model, node(i), _c.displacement + 3 * i, _c.node_force + 3 * i);
  }

  void compliances() {
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      double stiffness[9];
      force_jacobian(_model, node(i), _c.displacement + 3 * i, stiffness);
      invert(stiffness, _c.compliance + 9 * i);
    }
  }

  /// What every node does to every tool's point.
  void move_points() {
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
      const double* d = _c.displacement + 3 * i;
      local_basis(_model, node(i), d, _c.basis, _c.gradient, _c.kernel);
      for (std::int32_t t = 0; t < _c.n_tools; ++t)
        local_displacement(_c.local[at(t, i)], basis_size(_model, node(i)), d, _c.basis, _c.gradient,
                           _c.moved + 3 * at(t, i), _c.jacobian + 9 * at(t, i));
    }
  }

  /// How far tool t's point is from `share` of its target.
  void missing(std::int32_t t, double share, double* r) const {
    for (int k = 0; k < 3; ++k) {
      r[k] = share * _targets[3 * t + k];
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) r[k] -= _c.moved[3 * at(t, i) + k];
    }
  }

  /// matrix_ts = sum_i jacobian_ti compliance_i weight_si
  void assemble() {
    const std::int32_t n = 3 * _c.n_tools;
    for (std::int32_t i = 0; i < n * n; ++i) _c.matrix[i] = 0;
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        double product[9];
        multiply_matrices(_c.jacobian + 9 * at(t, i), _c.compliance + 9 * i, product);
        for (std::int32_t s = 0; s < _c.n_tools; ++s) {
          const double w = weight(s, i);
          for (int k = 0; k < 9 && w != 0; ++k)
            _c.matrix[(3 * t + k / 3) * n + 3 * s + k % 3] += w * product[k];
        }
      }
    }
  }

  /// Scales the steps of all nodes alike so that none is too long. @return the factor
  double limit(double& longest) const {
    longest = 0;
    for (std::int32_t i = 0; i < _c.n_nodes; ++i) longest = std::fmax(longest, length(_c.step + 3 * i));
    if (_model.family == Family::linear) return 1;
    const double allowed = longest_step * _model.max_displacement;
    return longest > allowed ? allowed / longest : 1;
  }

  /// Newton's method for   node_force_i(d_i) = sum_t weight_ti force_t,   sum_i moved_ti(d_i) = target_t.
  bool iterate(double share, std::int32_t most) {
    for (std::int32_t n = 0; n < most; ++n) {
      ++_iterations;
      forces();
      compliances();
      move_points();
      assemble();
      // step_i first holds compliance_i times the force that node i lacks.
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        double lack[3];
        for (int k = 0; k < 3; ++k) {
          lack[k] = -_c.node_force[3 * i + k];
          for (std::int32_t t = 0; t < _c.n_tools; ++t) lack[k] += weight(t, i) * _c.force[3 * t + k];
        }
        multiply(_c.compliance + 9 * i, lack, _c.step + 3 * i);
      }
      for (std::int32_t t = 0; t < _c.n_tools; ++t) {
        double* right = _c.right + 3 * t;
        missing(t, share, right);
        for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
          double already[3];
          multiply(_c.jacobian + 9 * at(t, i), _c.step + 3 * i, already);
          for (int k = 0; k < 3; ++k) right[k] -= already[k];
        }
      }
      if (!solve_dense(_c.matrix, 3 * _c.n_tools, _c.right, 1)) return false;
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        double more[3] = {0, 0, 0}, moves[3];
        for (std::int32_t t = 0; t < _c.n_tools; ++t) {
          for (int k = 0; k < 3; ++k) more[k] += weight(t, i) * _c.right[3 * t + k];
        }
        multiply(_c.compliance + 9 * i, more, moves);
        for (int k = 0; k < 3; ++k) _c.step[3 * i + k] += moves[k];
      }
      double longest = 0, far = 0;
      const double factor = limit(longest);
      if (!std::isfinite(longest)) return false;
      for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i) _c.displacement[i] += factor * _c.step[i];
      for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) _c.force[i] += factor * _c.right[i];
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) far = std::fmax(far, length(_c.displacement + 3 * i));
      if (longest <= settled_step * far) return true;
    }
    return false;
  }

  /// Where no balance was found: displacements in the proportions that a body without curvature has, so that the
  /// points follow the tools; and the forces that fit those of the nodes best.
  void fall_back() {
    set_to_rest();
    compliances();
    const std::int32_t n = 3 * _c.n_tools;
    for (std::int32_t k = 0; k < fallback_iterations; ++k) {
      ++_iterations;
      move_points();
      assemble();
      for (std::int32_t t = 0; t < _c.n_tools; ++t) missing(t, 1, _c.right + 3 * t);
      if (!solve_dense(_c.matrix, n, _c.right, 1)) break;
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) {
        double share[3] = {0, 0, 0};
        for (std::int32_t t = 0; t < _c.n_tools; ++t) {
          for (int l = 0; l < 3; ++l) share[l] += weight(t, i) * _c.right[3 * t + l];
        }
        multiply(_c.compliance + 9 * i, share, _c.step + 3 * i);
      }
      double longest = 0, far = 0;
      const double factor = limit(longest);
      if (!std::isfinite(longest)) break;
      for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i) _c.displacement[i] += factor * _c.step[i];
      for (std::int32_t i = 0; i < _c.n_nodes; ++i) far = std::fmax(far, length(_c.displacement + 3 * i));
      if (longest <= settled_step * far) break;
    }
    forces();
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        double sum = 0;
        for (std::int32_t i = 0; i < _c.n_nodes; ++i) sum += weight(t, i) * weight(s, i);
        _c.matrix[t * _c.n_tools + s] = sum;
      }
      for (int k = 0; k < 3; ++k) {
        _c.right[3 * t + k] = 0;
        for (std::int32_t i = 0; i < _c.n_nodes; ++i) _c.right[3 * t + k] += weight(t, i) * _c.node_force[3 * i + k];
      }
    }
    if (!solve_dense(_c.matrix, _c.n_tools, _c.right, 3)) return;
    for (std::int32_t i = 0; i < n; ++i) _c.force[i] = _c.right[i];
  }

  CoupledResult result(bool settled) {
    bool finite = true;
    for (std::int32_t i = 0; i < 3 * _c.n_nodes; ++i) finite = finite && std::isfinite(_c.displacement[i]);
    for (std::int32_t i = 0; i < 3 * _c.n_tools; ++i) finite = finite && std::isfinite(_c.force[i]);
    if (!finite) set_to_rest();
    CoupledResult result = {settled && finite, 0, 0, _iterations};
    move_points();
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      double r[3], u[3], own[3] = {0, 0, 0};
      missing(t, 1, r);
      result.residual = std::fmax(result.residual, length(r));
      for (int k = 0; k < 3; ++k) {
        u[k] = _targets[3 * t + k] - r[k];
        for (std::int32_t i = 0; i < _c.n_nodes; ++i) own[k] += weight(t, i) * _c.displacement[3 * i + k];
        // What the nodes do to each other, once for each pair.
        if (has_energy(_model)) result.energy += _c.force[3 * t + k] * (u[k] - own[k]) / 2;
      }
    }
    for (std::int32_t i = 0; i < _c.n_nodes && has_energy(_model); ++i)
      result.energy += evaluate_energy(_model, node(i), _c.displacement + 3 * i);
    return result;
  }

  const phn_model& _model;
  Coupling& _c;
  const double* _targets;
  std::int32_t _iterations = 0;
};

}  // namespace

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  const auto t = static_cast<std::size_t>(c.max_tools), n = 3 * t;
  std::size_t basis = 3;
  for (std::int32_t i = 0; i < model.n_active; ++i) {
    const auto size = static_cast<std::size_t>(basis_size(model, model.active[i]));
    basis = size > basis ? size : basis;
  }
  c.active = arena.take<std::int32_t>(n);
  c.displacement = arena.take<double>(3 * n);
  c.force = arena.take<double>(3 * t);
  c.weight = arena.take<double>(t * n);
  c.old_active = arena.take<std::int32_t>(n);
  c.old_displacement = arena.take<double>(3 * n);
  c.node_force = arena.take<double>(3 * n);
  c.step = arena.take<double>(3 * n);
  c.compliance = arena.take<double>(9 * n);
  c.moved = arena.take<double>(3 * t * n);
  c.jacobian = arena.take<double>(9 * t * n);
  c.local = arena.take<LocalResponse>(t * n);
  auto* rows = arena.take<double>(3 * basis * t * n);
  for (std::size_t i = 0; c.local && rows && i < t * n; ++i) c.local[i].rows = rows + 3 * basis * i;
  c.basis = arena.take<double>(basis);
  c.gradient = arena.take<double>(3 * basis);
  c.kernel = arena.take<double>(4 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  c.matrix = arena.take<double>(n * n);
  c.right = arena.take<double>(n);
  return c;
}

void begin_coupling(Coupling& c, std::int32_t n_tools, std::int32_t n_nodes, const std::int32_t* active,
                    const double* weight) {
  const std::int32_t n_old = c.n_nodes;
  for (std::int32_t i = 0; i < n_old; ++i) c.old_active[i] = c.active[i];
  for (std::int32_t i = 0; i < 3 * n_old; ++i) c.old_displacement[i] = c.displacement[i];
  if (n_tools != c.n_tools) {
    for (std::int32_t i = 0; i < 3 * n_tools; ++i) c.force[i] = 0;
  }
  for (std::int32_t i = 0; i < n_nodes; ++i) {
    c.active[i] = active[i];
    for (int k = 0; k < 3; ++k) c.displacement[3 * i + k] = 0;
    for (std::int32_t j = 0; j < n_old; ++j) {
      for (int k = 0; k < 3 && c.old_active[j] == active[i]; ++k)
        c.displacement[3 * i + k] = c.old_displacement[3 * j + k];
    }
  }
  for (std::int32_t i = 0; i < n_tools * n_nodes; ++i) c.weight[i] = weight[i];
  c.n_tools = n_tools;
  c.n_nodes = n_nodes;
}

CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const SurfacePoint* points,
                            const double* targets) {
  return Solver(model, coupling, targets).run(points);
}

}  // namespace phynness::runtime
