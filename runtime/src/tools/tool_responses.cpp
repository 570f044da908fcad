#include "tools/tool_responses.hpp"

#include <cmath>

#include "core/evaluate.hpp"
#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

/// Gauss-Legendre quadrature on 0 ... 1, exact for polynomials of degree 5.
constexpr double gauss_point[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weight[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};

/// Square roots, and the inverse, of a symmetric matrix that is made positive definite first.
void find_roots(Matrix a, Matrix& root, Matrix& inverse_root, Matrix& inverse) {
  Matrix v;
  diagonalize(a.a, 3, v.a);
  const double least = 1e-3 * (std::fabs(a(0, 0)) + std::fabs(a(1, 1)) + std::fabs(a(2, 2)));
  root = inverse_root = inverse = {};
  for (int e = 0; e < 3; ++e) {
    const double value = std::fmax(a(e, e), least), square_root = std::sqrt(value);
    for (int k = 0; k < 9; ++k) {
      const double product = v(k / 3, e) * v(k % 3, e);
      root.a[k] += square_root * product;
      inverse_root.a[k] += square_root > 0 ? product / square_root : 0;
      inverse.a[k] += value > 0 ? product / value : 0;
    }
  }
}

bool all_round(const phn_model& model, const Coupling& c) {
  bool all = true;
  for (std::int32_t t = 0; t < c.n_tools; ++t) all = all && is_round(model, c.point[t]);
  return all;
}

}  // namespace

ToolResponses::ToolResponses(const phn_model& model, Coupling& coupling)
    : _model(model), _c(coupling), _round(all_round(model, coupling)) {
  // Fixed corners do not count.
  for (std::int32_t t = 0; t < _c.n_tools && _round; ++t) {
    HeldPoint& point = _c.point[t];
    point.mean = mean_at(_model, _c.neighbours, point);
    for (std::int32_t i = 0; i < point.n_nodes; ++i) point.weight[i] = point.mean.share[i];
  }
}

Matrix ToolResponses::rest_response(const LocalResponse& local, std::int32_t n, const double* gradient) const {
  Matrix response;
  for (int k = 0; k < 3; ++k) {
    const Vector u = local_displacement(local, 0, unit_vector(k), n, gradient + k * n);
    for (int l = 0; l < 3; ++l) response(l, k) = u[l];
  }
  return response;
}

double ToolResponses::respond(std::int32_t s, const Vector& p) {
  HeldPoint& point = _c.point[s];
  point.own = p;
  take_response(s);
  pull(s);
  return point.energy + (_round ? 0 : energy_of_nodes(point));
}

void ToolResponses::prepare(std::int32_t s) {
  HeldPoint& point = _c.point[s];
  Matrix compliance[most_corners], between[most_corners][most_corners], sum = {};
  point.own = {};
  point.curved = 0;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    point.rest_stiffness[i] = stiffness_at_rest(_model, by);
    if (turns()) point.curved += point.weight[i] * curvature(_model, by, point.rest_stiffness[i]);
    compliance[i] = inverse_of(point.rest_stiffness[i]);
    basis_gradient_at_rest(_model, by, gradient_at_rest(s, i), _c.kernel, _c.basis);
    const std::int32_t n = basis_size(_model, by);
    for (std::int32_t j = 0; j < point.n_nodes && !_round; ++j) {
      const double one = 1;
      prepare_local(by, 1, &point.active[j], &one, _c.pair);
      between[j][i] = rest_response(_c.pair, n, gradient_at_rest(s, i));
      sum += (point.weight[j] * point.weight[i]) * (between[j][i] * compliance[i]);
    }
    for (std::int32_t t = 0; t < _c.n_tools && !_round; ++t) {
      const HeldPoint& other = _c.point[t];
      LocalResponse& local = _c.local[at(t, s, i)];
      prepare_local(by, other.n_nodes, other.active, other.weight, local);
      _c.rest_response[at(t, s, i)] = rest_response(local, n, gradient_at_rest(s, i));
    }
  }
  if (_round) return prepare_round(s);
  const Matrix inverse = inverse_of(sum);
  point.stiffness = symmetric_part(inverse);
  find_roots(point.stiffness, point.root, point.inverse_root, point.compliance);
  for (std::int32_t i = 0; i < point.n_nodes; ++i) point.contribution[i] = point.weight[i] * (compliance[i] * inverse);
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    point.reach[i] = {};
    for (std::int32_t j = 0; j < point.n_nodes; ++j) point.reach[i] += between[i][j] * point.contribution[j];
    const double square = inner_product(point.reach[i], point.reach[i]);
    point.share[i] = square > 0 ? inner_product(point.contribution[i], point.reach[i]) / square : 0;
  }
}

void ToolResponses::prepare_round(std::int32_t s) {
  HeldPoint& point = _c.point[s];
  Matrix stiffness = {};
  for (std::int32_t m = 0; m < point.mean.n; ++m)
    stiffness += point.mean.weight[m] * stiffness_at_rest(_model, _model.active[point.mean.active[m]]);
  find_roots(stiffness, point.root, point.inverse_root, point.compliance);
  point.stiffness = point.root * point.root;
  point.middle = {};
  for (std::int32_t i = 0; i < point.n_nodes; ++i) point.middle += point.weight[i] * vector_at(node(point, i).point);
  point.spread = 0;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    for (std::int32_t m = 0; m < by.n_prescribed; ++m) {
      const Vector away = vector_at(vertex_point(_model, by.prescribed[m])) - vector_at(by.point);
      point.spread += point.weight[i] * by.prescribed_weight[m] * dot(away, away);
    }
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    point.share[i] = point.weight[i];
    point.contribution[i] = diagonal(point.weight[i]);
    point.reach[i] = diagonal(1);
  }
}

void ToolResponses::prepare_means(std::int32_t t) {
  HeldPoint& to = _c.point[t];
  double *weight = _c.vertex_mean, *shared = weight + _model.n_output;
  for (std::int32_t s = 0; s < _c.n_tools; ++s) _c.wide[at(t, s)] = {};
  // By all nodes of (x), and then by the corners; at a node they are the same. A round tool that reaches nodes which
  // are no outputs has no known mean.
  bool corrected = to.mean.n > to.n_nodes;
  for (std::int32_t k = 0; k < to.mean.n; ++k) corrected = corrected && _model.active[to.mean.active[k]].output >= 0;
  for (int corners = corrected ? 0 : 1; corners < 2; ++corners) {
    const std::int32_t n_nodes = corners ? to.n_nodes : to.mean.n;
    const double *share = corners ? to.weight : to.mean.weight, part = !corners ? 1 : corrected ? -0.5 : 0.5;
    set_zero(weight, static_cast<std::size_t>(_model.n_output));
    for (std::int32_t k = 0; k < n_nodes; ++k) add_round_tool(_model.active[to.mean.active[k]], share[k], weight);
    sum_shared(_model, weight, shared);
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      const HeldPoint& point = _c.point[s];
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        const ActiveNode& by = node(point, i);
        std::int32_t k = 0;
        while (k < n_nodes && to.mean.active[k] != point.active[i]) ++k;
        LocalResponse& local = _c.local[at(t, s, i)];
        mean_response(_model, by, k < n_nodes ? share[k] : 0, weight, shared, _c.shared, local);
        Matrix& response = _c.rest_response[at(t, s, i)];
        response = rest_response(local, basis_size(_model, by), gradient_at_rest(s, i));
        _c.wide[at(t, s)] += (part * point.weight[i]) * (response * inverse_of(point.rest_stiffness[i]));
      }
    }
  }
  for (std::int32_t i = 0; i < to.n_nodes; ++i) {  // the tool's own mean moves by p
    clear_local(_model, node(to, i), _c.local[at(t, t, i)]);
    _c.local[at(t, t, i)].direct = _c.rest_response[at(t, t, i)] = diagonal(1);
  }
  Matrix root, inverse;
  find_roots(2 * symmetric_part(to.root * _c.wide[at(t, t)] * to.root), root, to.scale, inverse);
}

void ToolResponses::match_round_tools() {
  for (std::int32_t t = 0; t < _c.n_tools; ++t) prepare_means(t);
  for (std::int32_t t = 0; t < _c.n_tools; ++t) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      const HeldPoint &to = _c.point[t], &by = _c.point[s];
      if (t == s || (to.n_nodes == 1 && by.n_nodes == 1)) continue;
      const Matrix compliance = _c.wide[at(t, s)] + transposed(_c.wide[at(s, t)]);
      Matrix change = to.inverse_root * to.scale * to.root * compliance * by.root * by.scale * by.root;
      for (std::int32_t i = 0; i < by.n_nodes; ++i) change -= by.weight[i] * _c.rest_response[at(t, s, i)];
      for (std::int32_t i = 0; i < by.n_nodes; ++i) {
        _c.local[at(t, s, i)].direct += change;
        _c.rest_response[at(t, s, i)] += change;
      }
    }
  }
}

void ToolResponses::prepare_local(const ActiveNode& by, std::int32_t n, const std::int32_t* active,
                                  const double* weight, LocalResponse& local) const {
  std::int32_t vertices[most_corners];
  Matrix maps[most_corners];
  for (std::int32_t k = 0; k < n; ++k) {
    vertices[k] = _model.active[active[k]].output;
    maps[k] = diagonal(weight[k]);
  }
  clear_local(_model, by, local);
  add_local(_model, by, n, vertices, maps, _c.shared, local);
}

void ToolResponses::prepare_turn(std::int32_t t) {
  HeldPoint& point = _c.point[t];
  SurfaceTurn& turn = *_c.turn;
  std::int32_t vertex[most_corners];
  for (std::int32_t j = 0; j < point.n_nodes; ++j) vertex[j] = node(point, j).output;
  turn.triangle = 0;
  turn.area = 0;
  for (bool first = true; next_turn(_model, point.n_nodes, vertex, point.weight, turn) || first; first = false) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
        const ActiveNode& by = node(_c.point[s], i);
        const std::size_t k = at(place(_c.n_tools + t), s, i);
        LocalResponse& local = _c.local[k];
        if (first) clear_local(_model, by, local);
        if (s != t) add_local(_model, by, turn.n, turn.vertex, turn.map, _c.shared, local);
        _c.rest_response[k] = rest_response(local, basis_size(_model, by), gradient_at_rest(s, i));
      }
    }
  }
  point.area = turn.area;
}

void ToolResponses::take_response(std::int32_t s) {
  HeldPoint& point = _c.point[s];
  Vector r = point.own;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const std::int32_t n = basis_size(_model, node(point, i));
    const Vector q = point.contribution[i] * point.own, e = point.reach[i] * point.own;
    const double square = dot(e, e), share = square > 0 ? dot(q, e) / square : 0;
    const Vector left = q - share * e;
    basis_of(_model, node(point, i), e.x, _c.basis, _c.kernel);
    const double* gradient = gradient_at_rest(s, i);
    double* basis = node_basis(s, i);
    for (std::int32_t j = 0; j < n; ++j)
      basis[j] =
          share * _c.basis[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
    point.node_share[i] = share;
    point.node_own[i] = q;
    r -= local_displacement(_c.local[at(s, s, i)], share, q, n, basis);
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i) move_at_rest(s, i, r, 1, node_basis(s, i), point.node_own[i]);
}

void ToolResponses::move_at_rest(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis,
                                 Vector& own) const {
  const HeldPoint& point = _c.point[s];
  const std::int32_t n = basis_size(_model, node(point, i));
  const double* gradient = gradient_at_rest(s, i);
  const Vector q = weight * (point.contribution[i] * r);
  for (int k = 0; k < 3; ++k) add_scaled(q[k], gradient + k * n, n, basis);
  own += q;
}

Vector ToolResponses::displaced(std::int32_t t, std::int32_t s) const {
  const HeldPoint& point = _c.point[s];
  Vector u = {};
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    u += local_displacement(_c.local[at(t, s, i)], point.node_share[i], point.node_own[i],
                            basis_size(_model, node(point, i)), node_basis(s, i));
  return u;
}

Matrix ToolResponses::rest_block(std::int32_t t, std::int32_t s) const {
  Matrix block;
  for (int k = 0; k < 9; ++k) block.a[k] = _c.matrix[(3 * t + k / 3) * 3 * _c.n_tools + 3 * s + k % 3];
  return block;
}

void ToolResponses::add_derivatives(std::int32_t t, std::int32_t i) {
  const HeldPoint& point = _c.point[t];
  const ActiveNode& by = node(point, i);
  const std::int32_t n = basis_size(_model, by);
  const Matrix &to_q = point.contribution[i], &to_e = point.reach[i];
  const Vector q = to_q * point.own, e = to_e * point.own;
  const double square = dot(e, e), share = point.node_share[i];
  // d(share)/dp for share = q . e / e . e
  Vector by_share = {};
  if (square > 0)
    by_share =
        (transposed_times(to_q, e) + transposed_times(to_e, q) - (2 * share) * transposed_times(to_e, e)) / square;
  const Matrix left = to_q - share * to_e - outer(e, by_share);
  basis_and_gradient(_model, by, e.x, _c.basis, _c.gradient, _c.kernel);
  for (std::int32_t s = 0; s < n_places(); ++s) {
    const LocalResponse& local = _c.local[at(place(s), t, i)];
    Matrix change = {};
    Vector value = local.constant;
    for (int r = 0; r < 3; ++r) {
      for (std::int32_t j = 0; j < n; ++j) {
        const double weight = local.rows[r * n + j];
        value[r] += weight * _c.basis[j];
        for (int k = 0; k < 3; ++k) change(r, k) += weight * _c.gradient[k * n + j];
      }
    }
    Matrix& sum = _c.derivative[at(place(s), t)];
    sum += share * (change * to_e) + outer(value, by_share);
    sum += local.direct * to_q;
    sum += (_c.rest_response[at(place(s), t, i)] - local.direct) * left;
  }
}

void ToolResponses::find_derivatives(std::int32_t t) {
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] = {};
  for (std::int32_t i = 0; i < _c.point[t].n_nodes; ++i) add_derivatives(t, i);
  // The remaining displacement of the tool's point is added as in the undeformed body.
  const Matrix lacks = diagonal(1) - _c.derivative[at(t, t)];
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] += rest_block(s, t) * lacks;
}

void ToolResponses::set_rest_matrix() {
  const std::int32_t n = 3 * _c.n_tools;
  set_zero(_c.matrix, 3 * static_cast<std::size_t>(n_places()) * static_cast<std::size_t>(n));
  for (std::int32_t t = 0; t < n_places(); ++t) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
        const Matrix product = _c.rest_response[at(place(t), s, i)] * _c.point[s].contribution[i];
        for (int k = 0; k < 9; ++k) _c.matrix[(3 * t + k / 3) * n + 3 * s + k % 3] += product.a[k];
      }
    }
  }
}

bool ToolResponses::is_beyond(std::int32_t s, double times) const {
  const HeldPoint& point = _c.point[s];
  if (!_round || schema::traits(_model.kind).proportional) return false;
  const Vector p = point.compliance * point.force;
  const double size = length(p.x);
  double depth = size;
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    depth = std::fmin(depth, depth_slack<double> * trained_depth(_model, node(point, i), p.x));
  if (!(size > times * depth)) return false;
  Vector trained;
  respond_alone(_model, point.mean, (depth / size) * p, trained, nullptr, nullptr);
  return dot(point.force, p) > times * dot(trained, p);
}

double ToolResponses::energy_of_nodes(const HeldPoint& point) const {
  double energy = 0;
  for (std::int32_t i = 0; i < point.n_nodes && _model.has_energy; ++i) {
    Vector force;
    double one = 0;
    evaluate_force(_model, node(point, i), (point.reach[i] * point.own).x, force.x, &one, nullptr);
    energy += point.share[i] * one;
  }
  return energy;
}

void ToolResponses::pull(std::int32_t s) {
  HeldPoint& point = _c.point[s];
  if (_round) {
    respond_alone(_model, point.mean, point.own, point.force, _model.has_energy ? &point.energy : nullptr, nullptr);
    if (!_model.has_energy) point.energy = 0;
    return;
  }
  const Vector linear = point.stiffness * point.own;
  double energy = dot(linear, point.own) / 2;
  point.force = linear;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const Vector e = point.reach[i] * point.own, ke = point.rest_stiffness[i] * e;
    Vector f;
    evaluate_force(_model, node(point, i), e.x, f.x);
    point.force += point.share[i] * transposed_times(point.reach[i], f - ke);
    energy -= point.share[i] * dot(ke, e) / 2;
    // A single node follows the tool exactly, so that psi is 0.
    for (int g = 0; g < 3 && point.n_nodes > 1; ++g)
      energy -= pull_of_coupling(s, i, e, linear, gauss_point[g], gauss_weight[g]);
  }
  point.energy = energy;
}

double ToolResponses::pull_of_coupling(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x,
                                       double w) {
  HeldPoint& point = _c.point[s];
  const ActiveNode& by = node(point, i);
  const LocalResponse& local = _c.local[at(s, s, i)];
  const double* rest_gradient = gradient_at_rest(s, i);
  const std::int32_t n = basis_size(_model, by);
  const Vector there = x * e;
  basis_and_gradient(_model, by, there.x, _c.basis, _c.gradient, _c.kernel);
  const Vector z = local_displacement(local, 1, there, n, _c.basis) - _c.rest_response[at(s, s, i)] * there;
  // (dz/de)^T A p
  Vector back = {};
  for (int r = 0; r < 3; ++r) {
    const double* row = local.rows + r * n;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::int32_t j = 0; j < n; ++j) sum += row[j] * (_c.gradient[k * n + j] - rest_gradient[k * n + j]);
      back[k] += x * linear[r] * sum;
    }
  }
  point.force -= (w * point.share[i]) * (point.stiffness * z + transposed_times(point.reach[i], back));
  return w * point.share[i] * dot(linear, z);
}

}  // namespace PHN_RUNTIME
