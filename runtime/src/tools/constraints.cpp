#include "tools/constraints.hpp"

#include <cmath>

#include "core/evaluate.hpp"

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

/// Gauss-Legendre quadrature on 0 ... 1, exact for polynomials of degree 5.
constexpr double gauss_point[3] = {0.11270166537925831, 0.5, 0.88729833462074169};
constexpr double gauss_weight[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18};

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
  find_turn(_model, point.n_nodes, vertex, point.weight, turn);
  for (std::int32_t s = 0; s < _c.n_tools; ++s) {
    for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
      const ActiveNode& by = node(_c.point[s], i);
      const std::size_t k = at(place(_c.n_tools + t), s, i);
      NodeField& local = _c.displacement[k];
      clear(_model, by, local);
      if (s != t) add_vertices(_model, by, turn.n, turn.vertex, turn.map, _c.shared, local);
      _c.rest_response[k] = rest_response(local, basis_size(_model, by), gradient_at_rest(s, i));
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

double Constraints::respond(std::int32_t s, const Vector& p) {
  Constraint& point = _c.point[s];
  point.own = p;
  take_response(s);
  pull(s);
  return point.energy + energy_of_nodes(point);
}

void Constraints::take_response(std::int32_t s) {
  Constraint& point = _c.point[s];
  Vector r = point.own;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const std::int32_t n = basis_size(_model, node(point, i));
    const Vector q = point.contribution[i] * point.own, e = point.reach[i] * point.own;
    const double square = dot(e, e), share = square > 0 ? dot(q, e) / square : 0;
    const Vector left = q - share * e;
    basis_of(_model, node(point, i), e.x, _c.basis, _c.kernel);
    const double* gradient = gradient_at_rest(s, i);
    double* basis = response_basis(s, i);
    for (std::int32_t j = 0; j < n; ++j)
      basis[j] =
          share * _c.basis[j] + left[0] * gradient[j] + left[1] * gradient[n + j] + left[2] * gradient[2 * n + j];
    point.response_share[i] = share;
    point.response_own[i] = q;
    r -= displacement_of(_c.displacement[at(s, s, i)], share, q, n, basis);
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    move_at_rest(s, i, r, 1, response_basis(s, i), point.response_own[i]);
}

Vector Constraints::displaced(std::int32_t t, std::int32_t s) const {
  const Constraint& point = _c.point[s];
  Vector u = {};
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    u += displacement_of(_c.displacement[at(t, s, i)], point.response_share[i], point.response_own[i],
                         basis_size(_model, node(point, i)), response_basis(s, i));
  return u;
}

void Constraints::add_derivatives(std::int32_t t, std::int32_t i) {
  const Constraint& point = _c.point[t];
  const ActiveNode& by = node(point, i);
  const std::int32_t n = basis_size(_model, by);
  const Matrix &to_q = point.contribution[i], &to_e = point.reach[i];
  const Vector q = to_q * point.own, e = to_e * point.own;
  const double square = dot(e, e), share = point.response_share[i];
  // d(share)/dp for share = q . e / e . e
  Vector by_share = {};
  if (square > 0)
    by_share =
        (transposed_times(to_q, e) + transposed_times(to_e, q) - (2 * share) * transposed_times(to_e, e)) / square;
  const Matrix left = to_q - share * to_e - outer(e, by_share);
  basis_and_gradient(_model, by, e.x, _c.basis, _c.gradient, _c.kernel);
  for (std::int32_t s = 0; s < n_places(); ++s) {
    const NodeField& local = _c.displacement[at(place(s), t, i)];
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

void Constraints::find_derivatives(std::int32_t t) {
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] = {};
  for (std::int32_t i = 0; i < _c.point[t].n_nodes; ++i) add_derivatives(t, i);
  // The remaining displacement of the tool's point is added as in the undeformed body.
  const Matrix lacks = diagonal(1) - _c.derivative[at(t, t)];
  for (std::int32_t s = 0; s < n_places(); ++s) _c.derivative[at(place(s), t)] += rest_block(s, t) * lacks;
}

double Constraints::energy_of_nodes(const Constraint& point) const {
  double energy = 0;
  for (std::int32_t i = 0; i < point.n_nodes && _model.has_energy; ++i) {
    Vector force;
    double one = 0;
    evaluate_force(_model, node(point, i), (point.reach[i] * point.own).x, force.x, &one, nullptr);
    energy += point.share[i] * one;
  }
  return energy;
}

void Constraints::pull(std::int32_t s) {
  Constraint& point = _c.point[s];
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

double Constraints::pull_of_coupling(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x,
                                     double w) {
  Constraint& point = _c.point[s];
  const ActiveNode& by = node(point, i);
  const NodeField& local = _c.displacement[at(s, s, i)];
  const double* rest_gradient = gradient_at_rest(s, i);
  const std::int32_t n = basis_size(_model, by);
  const Vector there = x * e;
  basis_and_gradient(_model, by, there.x, _c.basis, _c.gradient, _c.kernel);
  const Vector z = displacement_of(local, 1, there, n, _c.basis) - _c.rest_response[at(s, s, i)] * there;
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

Coupling* make_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools) {
  auto* made = arena.take<Coupling>(1);
  Coupling c = {};
  c.max_tools = max_tools < most_coupled ? max_tools : most_coupled;
  c.model = &model;
  c.neighbours = find_neighbours(arena, model);
  const bool round = has_round_tools(model);
  c.n_corners = round ? most_corners : most_nodes;
  // With a single tool no rotations are needed.
  const std::size_t t = round ? 1 : static_cast<std::size_t>(c.max_tools), n_places = t > 1 ? 2 * t : 1,
                    n_sets = t > 1 ? 1 + t : 1, n_corners = static_cast<std::size_t>(c.n_corners) * t,
                    n_fields = n_corners * n_places;
  c.point = arena.take<Constraint>(t);
  c.field = arena.take<FieldPart>(n_corners * n_sets);
  c.field_basis = arena.take<double>(n_corners * n_sets, model.n_basis);
  c.field_turn = arena.take<Vector>(n_sets);
  c.kernel = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  c.displacement = arena.take<NodeField>(n_fields);
  auto* rows = arena.take<double>(3 * model.n_basis, n_fields + 1);
  for (std::size_t i = 0; c.displacement && rows && i < n_fields; ++i)
    c.displacement[i].rows = rows + 3 * model.n_basis * i;
  c.pair.rows = rows ? rows + 3 * model.n_basis * n_fields : nullptr;
  c.rest_response = arena.take<Matrix>(n_fields);
  c.rest_gradient = arena.take<double>(3 * n_corners, model.n_basis);
  c.response_basis = arena.take<double>(n_corners, model.n_basis);
  c.turn = arena.take<SurfaceTurn>(n_sets > 1);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  const auto n_shared = 3 * static_cast<std::size_t>(model.shared.n_modes);
  c.shared = arena.take<double>(n_shared > model.n_basis ? n_shared : model.n_basis);
  c.matrix = arena.take<double>(9 * n_places * t);
  c.work = arena.take<double>(9 * t * t);
  c.vectors = arena.take<double>(9 * t * t);
  c.stiffness = arena.take<Matrix>(t * t);
  c.derivative = arena.take<Matrix>(n_places * t);
  c.residual = arena.take<Vector>(t * t);
  c.multiplier = arena.take<Vector>(t * t);
  c.turned = arena.take<Vector>(t * t);
  c.right = arena.take<Vector>(t);
  c.forces = arena.take<Vector>(t);
  c.single_force = arena.take<Vector>(t);
  c.energy = arena.take<double>(t);
  c.weight = arena.take<double>(t);
  if (made != nullptr && !arena.overflow()) *made = c;
  return made;
}

void coupled_field(const phn_model& model, const Coupling& c, PreparedNodes& prepared, double* scratch, double* one,
                   double* field) {
  for (std::int32_t set = 0; set < c.n_sets; ++set) {
    for (std::int32_t s = 0; s < c.n_tools; ++s) {
      const Constraint& point = c.point[s];
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        const auto at = static_cast<std::size_t>(c.n_corners * (set * c.max_tools + s) + i);
        field_of_basis(model, model.active[point.active[i]], prepare(model, prepared, point.active[i]),
                       c.field[at].share, c.field[at].own.x, c.field_basis + at * model.n_basis, scratch, one);
        for (std::int32_t o = 0; o < model.n_output; ++o) {
          const Vector turned = rotated(c.field_turn[set], vector_at(one + 3 * o));
          for (int k = 0; k < 3; ++k) field[3 * o + k] += turned[k];
        }
      }
    }
  }
}

}  // namespace PHN_RUNTIME
