#include "tools/constraints.hpp"

#include <cmath>

namespace PHN_RUNTIME {
namespace {

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

}  // namespace

void Constraints::prepare(std::int32_t s) {
  Constraint& point = _c.point[s];
  Matrix compliance[most_nodes], between[most_nodes][most_nodes], sum = {};
  point.own = {};
  point.curved = 0;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    point.rest_stiffness[i] = stiffness_at_rest(_model, by);
    if (turns()) point.curved += point.weight[i] * curvature(_model, by, point.rest_stiffness[i]);
    compliance[i] = inverse_of(point.rest_stiffness[i]);
    basis_gradient_at_rest(_model, by, gradient_at_rest(s, i), _c.kernel, _c.basis);
    const std::int32_t n = basis_size(_model, by);
    for (std::int32_t j = 0; j < point.n_nodes; ++j) {
      const double one = 1;
      prepare_field(by, 1, &point.active[j], &one, _c.pair);
      between[j][i] = rest_response(_c.pair, n, gradient_at_rest(s, i));
      sum += (point.weight[j] * point.weight[i]) * (between[j][i] * compliance[i]);
    }
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const Constraint& other = _c.point[t];
      NodeField& local = _c.displacement[at(t, s, i)];
      prepare_field(by, other.n_nodes, other.active, other.weight, local);
      _c.rest_response[at(t, s, i)] = rest_response(local, n, gradient_at_rest(s, i));
    }
  }
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

void Constraints::prepare_field(const ActiveNode& by, std::int32_t n, const std::int32_t* active, const double* weight,
                                NodeField& local) const {
  std::int32_t vertices[most_nodes];
  Matrix maps[most_nodes];
  for (std::int32_t k = 0; k < n; ++k) {
    vertices[k] = _model.active[active[k]].output;
    maps[k] = diagonal(weight[k]);
  }
  clear(_model, by, local);
  add_vertices(_model, by, n, vertices, maps, _c.shared, local);
}

void Constraints::prepare_turn(std::int32_t t) {
  Constraint& point = _c.point[t];
  SurfaceTurn& turn = *_c.turn;
  std::int32_t vertex[most_nodes];
  for (std::int32_t j = 0; j < point.n_nodes; ++j) vertex[j] = node(point, j).output;
  turn.triangle = 0;
  turn.area = 0;
  for (bool first = true; next_turn(_model, point.n_nodes, vertex, point.weight, turn) || first; first = false) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
        const ActiveNode& by = node(_c.point[s], i);
        const std::size_t k = at(place(_c.n_tools + t), s, i);
        NodeField& local = _c.displacement[k];
        if (first) clear(_model, by, local);
        if (s != t) add_vertices(_model, by, turn.n, turn.vertex, turn.map, _c.shared, local);
        _c.rest_response[k] = rest_response(local, basis_size(_model, by), gradient_at_rest(s, i));
      }
    }
  }
  point.area = turn.area;
}

Matrix Constraints::rest_response(const NodeField& local, std::int32_t n, const double* gradient) const {
  Matrix response;
  for (int k = 0; k < 3; ++k) {
    const Vector u = displacement_of(local, 0, unit_vector(k), n, gradient + k * n);
    for (int l = 0; l < 3; ++l) response(l, k) = u[l];
  }
  return response;
}

void Constraints::move_at_rest(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis,
                               Vector& own) const {
  const Constraint& point = _c.point[s];
  const std::int32_t n = basis_size(_model, node(point, i));
  const double* gradient = gradient_at_rest(s, i);
  const Vector q = weight * (point.contribution[i] * r);
  for (int k = 0; k < 3; ++k) add_scaled(q[k], gradient + k * n, n, basis);
  own += q;
}

void Constraints::set_rest_matrix() {
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

Matrix Constraints::rest_block(std::int32_t t, std::int32_t s) const {
  Matrix block;
  for (int k = 0; k < 9; ++k) block.a[k] = _c.matrix[(3 * t + k / 3) * 3 * _c.n_tools + 3 * s + k % 3];
  return block;
}

}  // namespace PHN_RUNTIME
