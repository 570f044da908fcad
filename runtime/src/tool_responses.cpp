#include "tool_responses.hpp"

#include <cmath>

#include "evaluate.hpp"
#include "small_matrices.hpp"

namespace PHN_RUNTIME {
namespace {

/// Gauss-Legendre on 0 ... 1: exact for the first six powers of the depth.
constexpr double gauss_point[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weight[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};

}  // namespace

void ToolResponses::rest_response(const LocalResponse& local, std::int32_t n, const double* gradient,
                                  double* response) const {
  for (int k = 0; k < 3; ++k) {
    const double unit[3] = {k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0};
    double u[3];
    local_displacement(local, 0, unit, n, gradient + k * n, u);
    for (int l = 0; l < 3; ++l) response[3 * l + k] = u[l];
  }
}

double ToolResponses::respond(std::int32_t s, const double* p) {
  HeldPoint& point = _c.point[s];
  for (int k = 0; k < 3; ++k) point.own[k] = p[k];
  take_response(s);
  pull(s);
  return point.energy + energy_of_nodes(point);
}

void ToolResponses::prepare(std::int32_t s) {
  HeldPoint& point = _c.point[s];
  double compliance[3][9], between[3][3][9], sum[9] = {}, inverse[9];
  point.curved = 0;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    stiffness_at_rest(_model, by, point.rest_stiffness[i]);
    if (turns()) point.curved += point.weight[i] * curvature(_model, by, point.rest_stiffness[i]);
    invert(point.rest_stiffness[i], compliance[i]);
    basis_gradient_at_rest(_model, by, gradient_at_rest(s, i), _c.kernel, _c.basis);
    const std::int32_t n = basis_size(_model, by);
    for (std::int32_t j = 0; j < point.n_nodes; ++j) {
      const double one = 1;
      prepare_local(by, 1, &node(point, j).output, &one, _c.pair);
      rest_response(_c.pair, n, gradient_at_rest(s, i), between[j][i]);
      double moved[9];
      multiply_matrices(between[j][i], compliance[i], moved);
      for (int k = 0; k < 9; ++k) sum[k] += point.weight[j] * point.weight[i] * moved[k];
    }
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const HeldPoint& other = _c.point[t];
      std::int32_t vertex[3];
      vertices_of(other, vertex);
      LocalResponse& local = _c.local[at(t, s, i)];
      prepare_local(by, other.n_nodes, vertex, other.weight, local);
      rest_response(local, n, gradient_at_rest(s, i), _c.rest_response + 9 * at(t, s, i));
    }
  }
  invert(sum, inverse);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) point.stiffness[3 * r + c] = (inverse[3 * r + c] + inverse[3 * c + r]) / 2;
  }
  find_roots(point);
  set_zero(point.own, 3);
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    multiply_matrices(compliance[i], inverse, point.contribution[i]);
    for (double& q : point.contribution[i]) q *= point.weight[i];
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    set_zero(point.reach[i], 9);
    for (std::int32_t j = 0; j < point.n_nodes; ++j) {
      double part[9];
      multiply_matrices(between[i][j], point.contribution[j], part);
      for (int k = 0; k < 9; ++k) point.reach[i][k] += part[k];
    }
    const double square = inner_product(point.reach[i], point.reach[i]);
    point.share[i] = square > 0 ? inner_product(point.contribution[i], point.reach[i]) / square : 0;
  }
}

void ToolResponses::vertices_of(const HeldPoint& point, std::int32_t* vertex) const {
  for (std::int32_t j = 0; j < point.n_nodes; ++j) vertex[j] = node(point, j).output;
}

void ToolResponses::prepare_local(const ActiveNode& by, std::int32_t n, const std::int32_t* vertices,
                                  const double* weight, LocalResponse& local) const {
  double maps[27];
  for (std::int32_t k = 0; k < 9 * n; ++k) maps[k] = k % 9 % 4 == 0 ? weight[k / 9] : 0;
  clear_local(_model, by, local);
  add_local(_model, by, n, vertices, maps, _c.shared, local);
}

void ToolResponses::prepare_turn(std::int32_t t) {
  HeldPoint& point = _c.point[t];
  SurfaceTurn& turn = *_c.turn;
  std::int32_t vertex[3];
  vertices_of(point, vertex);
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
        rest_response(local, basis_size(_model, by), gradient_at_rest(s, i), _c.rest_response + 9 * k);
      }
    }
  }
  point.area = turn.area;
}

void ToolResponses::find_roots(HeldPoint& point) {
  double a[9], v[9];
  for (int k = 0; k < 9; ++k) a[k] = point.stiffness[k];
  diagonalize(a, 3, v);
  const double least = 1e-3 * (std::fabs(a[0]) + std::fabs(a[4]) + std::fabs(a[8]));
  for (int k = 0; k < 9; ++k) point.root[k] = point.inverse_root[k] = point.compliance[k] = 0;
  for (int e = 0; e < 3; ++e) {
    const double value = std::fmax(a[4 * e], least), root = std::sqrt(value);
    for (int k = 0; k < 9; ++k) {
      const double product = v[3 * (k / 3) + e] * v[3 * (k % 3) + e];
      point.root[k] += root * product;
      point.inverse_root[k] += root > 0 ? product / root : 0;
      point.compliance[k] += value > 0 ? product / value : 0;
    }
  }
}

void ToolResponses::take_response(std::int32_t s) {
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
      basis[j] =
          share * _c.basis[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
    point.node_share[i] = share;
    for (int k = 0; k < 3; ++k) point.node_own[i][k] = q[k];
    local_displacement(_c.local[at(s, s, i)], share, q, n, basis, u);
    for (int k = 0; k < 3; ++k) r[k] -= u[k];
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i) move_at_rest(s, i, r, 1, node_basis(s, i), point.node_own[i]);
}

void ToolResponses::move_at_rest(std::int32_t s, std::int32_t i, const double* r, double weight, double* basis,
                                 double* own) const {
  const HeldPoint& point = _c.point[s];
  const std::int32_t n = basis_size(_model, node(point, i));
  const double* gradient = gradient_at_rest(s, i);
  double q[3];
  multiply(point.contribution[i], r, q);
  for (double& k : q) k *= weight;
  for (int k = 0; k < 3; ++k) add_scaled(q[k], gradient + k * n, n, basis);
  add_scaled(1, q, 3, own);
}

void ToolResponses::displaced(std::int32_t t, std::int32_t s, double* u) const {
  const HeldPoint& point = _c.point[s];
  set_zero(u, 3);
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    double by[3];
    local_displacement(_c.local[at(t, s, i)], point.node_share[i], point.node_own[i],
                       basis_size(_model, node(point, i)), node_basis(s, i), by);
    add_scaled(1, by, 3, u);
  }
}

void ToolResponses::rest_block(std::int32_t t, std::int32_t s, double* block) const {
  for (int k = 0; k < 9; ++k) block[k] = _c.matrix[(3 * t + k / 3) * 3 * _c.n_tools + 3 * s + k % 3];
}

void ToolResponses::find_derivatives(std::int32_t t) {
  HeldPoint& point = _c.point[t];
  for (std::int32_t s = 0; s < n_places(); ++s) {
    set_zero(_c.derivative + at9(place(s), t), 9);
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    const std::int32_t n = basis_size(_model, by);
    double q[3], e[3], to_q[3], to_e[3], by_share[3] = {0, 0, 0}, left[9];
    multiply(point.contribution[i], point.own, q);
    multiply(point.reach[i], point.own, e);
    const double square = dot(e, e), share = point.node_share[i];
    // d(share)/dp of share = q . e / e . e
    multiply_transposed(point.contribution[i], e, to_q);
    multiply_transposed(point.reach[i], q, to_e);
    multiply_transposed(point.reach[i], e, left);
    for (int k = 0; k < 3 && square > 0; ++k) by_share[k] = (to_q[k] + to_e[k] - 2 * share * left[k]) / square;
    for (int k = 0; k < 9; ++k)
      left[k] = point.contribution[i][k] - share * point.reach[i][k] - e[k / 3] * by_share[k % 3];
    basis_and_gradient(_model, by, e, _c.basis, _c.gradient, _c.kernel);
    for (std::int32_t s = 0; s < n_places(); ++s) {
      const LocalResponse& local = _c.local[at(place(s), t, i)];
      const double* rest = _c.rest_response + 9 * at(place(s), t, i);
      double indirect[9], change[9], part[9], value[3];
      for (int r = 0; r < 3; ++r) {
        value[r] = local.constant[r];
        for (int k = 0; k < 3; ++k) {
          indirect[3 * r + k] = rest[3 * r + k] - local.direct[3 * r + k];
          change[3 * r + k] = 0;
        }
        for (std::int32_t j = 0; j < n; ++j) {
          const double weight = local.rows[r * n + j];
          value[r] += weight * _c.basis[j];
          for (int k = 0; k < 3; ++k) change[3 * r + k] += weight * _c.gradient[k * n + j];
        }
      }
      double* sum = _c.derivative + at9(place(s), t);
      multiply_matrices(change, point.reach[i], part);
      for (int k = 0; k < 9; ++k) sum[k] += share * part[k] + value[k / 3] * by_share[k % 3];
      multiply_matrices(local.direct, point.contribution[i], part);
      add_scaled(1, part, 9, sum);
      multiply_matrices(indirect, left, part);
      add_scaled(1, part, 9, sum);
    }
  }
  // What a tool's own point lacks is added as in the undeformed body.
  double lacks[9];
  for (int k = 0; k < 9; ++k) lacks[k] = (k % 4 == 0 ? 1 : 0) - _c.derivative[at9(t, t) + k];
  for (std::int32_t s = 0; s < n_places(); ++s) {
    double moved[9], part[9];
    rest_block(s, t, moved);
    multiply_matrices(moved, lacks, part);
    add_scaled(1, part, 9, _c.derivative + at9(place(s), t));
  }
}

void ToolResponses::set_rest_matrix() {
  const std::int32_t n = 3 * _c.n_tools;
  for (std::int32_t k = 0; k < 3 * n_places() * n; ++k) _c.matrix[k] = 0;
  for (std::int32_t t = 0; t < n_places(); ++t) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
        double product[9];
        multiply_matrices(_c.rest_response + 9 * at(place(t), s, i), _c.point[s].contribution[i], product);
        for (int k = 0; k < 9; ++k) _c.matrix[(3 * t + k / 3) * n + 3 * s + k % 3] += product[k];
      }
    }
  }
}

double ToolResponses::energy_of_nodes(const HeldPoint& point) const {
  double energy = 0;
  for (std::int32_t i = 0; i < point.n_nodes && has_energy(_model); ++i) {
    double e[3];
    multiply(point.reach[i], point.own, e);
    energy += point.share[i] * evaluate_energy(_model, node(point, i), e);
  }
  return energy;
}

void ToolResponses::pull(std::int32_t s) {
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

double ToolResponses::pull_of_coupling(std::int32_t s, std::int32_t i, const double* e, const double* linear, double x,
                                       double w) {
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

}  // namespace PHN_RUNTIME
