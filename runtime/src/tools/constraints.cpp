#include "tools/constraints.hpp"

#include <cmath>

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Computes the square roots and the inverse of a symmetric matrix, which is made positive definite first.
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
  point.displacement = {};
  point.nonlinearity = 0;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const ActiveNode& by = node(point, i);
    point.node_stiffness[i] = stiffness_at_rest(_model, by);
    if (has_rotations()) point.nonlinearity += point.weight[i] * nonlinearity(_model, by, point.node_stiffness[i]);
    compliance[i] = inverse_of(point.node_stiffness[i]);
    basis_gradient_at_rest(_model, by, _c.rest_gradient(0, s, i), _c.kernel_scratch, _c.basis);
    const std::int32_t n = basis_size(_model, by);
    for (std::int32_t j = 0; j < point.n_nodes; ++j) {
      const double one = 1;
      prepare_field(by, 1, &point.active[j], &one, _c.pair_field);
      between[j][i] = rest_response(_c.pair_field, n, _c.rest_gradient(0, s, i));
      sum += (point.weight[j] * point.weight[i]) * (between[j][i] * compliance[i]);
    }
    for (std::int32_t t = 0; t < _c.n_tools; ++t) {
      const Constraint& other = _c.point[t];
      NodeField& local = _c.response(t, s, i);
      prepare_field(by, other.n_nodes, other.active, other.weight, local);
      _c.rest_response(t, s, i) = rest_response(local, n, _c.rest_gradient(0, s, i));
    }
  }
  const Matrix inverse = inverse_of(sum);
  point.stiffness = symmetric_part(inverse);
  find_roots(point.stiffness, point.stiffness_root, point.compliance_root, point.compliance);
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    point.node_contribution[i] = point.weight[i] * (compliance[i] * inverse);
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    point.node_displacement[i] = {};
    for (std::int32_t j = 0; j < point.n_nodes; ++j)
      point.node_displacement[i] += between[i][j] * point.node_contribution[j];
    const double square = inner_product(point.node_displacement[i], point.node_displacement[i]);
    point.node_factor[i] =
        square > 0 ? inner_product(point.node_contribution[i], point.node_displacement[i]) / square : 0;
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
  add_vertices(_model, by, n, vertices, maps, _c.mode_scratch, local);
}

void Constraints::prepare_rotation(std::int32_t t) {
  Constraint& point = _c.point[t];
  SurfaceRotation& rotation = *_c.surface_rotation;
  std::int32_t vertex[most_nodes];
  for (std::int32_t j = 0; j < point.n_nodes; ++j) vertex[j] = node(point, j).output;
  find_rotation(_model, point.n_nodes, vertex, point.weight, rotation);
  for (std::int32_t s = 0; s < _c.n_tools; ++s)
    for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
      const ActiveNode& by = node(_c.point[s], i);
      NodeField& local = _c.response(quantity(_c.n_tools + t), s, i);
      clear(_model, by, local);
      if (s != t) add_vertices(_model, by, rotation.n, rotation.vertex, rotation.map, _c.mode_scratch, local);
      _c.rest_response(quantity(_c.n_tools + t), s, i) =
          rest_response(local, basis_size(_model, by), _c.rest_gradient(0, s, i));
    }
  point.rotation_area = rotation.area;
}

Matrix Constraints::rest_response(const NodeField& local, std::int32_t n, const double* gradient) const {
  Matrix response;
  for (int k = 0; k < 3; ++k) {
    const Vector u = displacement_of(local, 0, unit_vector(k), n, gradient + k * n);
    for (int l = 0; l < 3; ++l) response(l, k) = u[l];
  }
  return response;
}

void Constraints::add_rest_response(std::int32_t s, std::int32_t i, const Vector& r, double weight, double* basis,
                                    Vector& displacement) const {
  const Constraint& point = _c.point[s];
  const std::int32_t n = basis_size(_model, node(point, i));
  const double* gradient = _c.rest_gradient(0, s, i);
  const Vector q = weight * (point.node_contribution[i] * r);
  for (int k = 0; k < 3; ++k) add_scaled(q[k], gradient + k * n, n, basis);
  displacement += q;
}

void Constraints::set_rest_matrix() {
  const std::int32_t n = 3 * _c.n_tools;
  const MatrixView<double> rest{_c.rest_matrix, n};
  set_zero(_c.rest_matrix, 3 * static_cast<std::size_t>(n_quantities()) * static_cast<std::size_t>(n));
  for (std::int32_t t = 0; t < n_quantities(); ++t)
    for (std::int32_t s = 0; s < _c.n_tools; ++s)
      for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i) {
        const Matrix product = _c.rest_response(quantity(t), s, i) * _c.point[s].node_contribution[i];
        for (int k = 0; k < 9; ++k) rest(3 * t + k / 3, 3 * s + k % 3) += product.a[k];
      }
}

Matrix Constraints::rest_block(std::int32_t t, std::int32_t s) const {
  const MatrixView<double> rest{_c.rest_matrix, 3 * _c.n_tools};
  Matrix block;
  for (int k = 0; k < 9; ++k) block.a[k] = rest(3 * t + k / 3, 3 * s + k % 3);
  return block;
}

double Constraints::respond(std::int32_t s, const Vector& p) {
  Constraint& point = _c.point[s];
  point.displacement = p;
  set_response(s);
  set_force(s);
  return point.energy + energy_of_nodes(point);
}

void Constraints::set_response(std::int32_t s) {
  Constraint& point = _c.point[s];
  Vector r = point.displacement;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const std::int32_t n = basis_size(_model, node(point, i));
    const Vector q = point.node_contribution[i] * point.displacement,
                 e = point.node_displacement[i] * point.displacement;
    const double square = dot(e, e), factor = square > 0 ? dot(q, e) / square : 0;
    const Vector rest = q - factor * e;
    basis_of(_model, node(point, i), e.x, _c.basis, _c.kernel_scratch);
    const double* gradient = _c.rest_gradient(0, s, i);
    double* basis = _c.response_basis(0, s, i);
    for (std::int32_t j = 0; j < n; ++j)
      basis[j] =
          factor * _c.basis[j] + rest[0] * gradient[j] + rest[1] * gradient[n + j] + rest[2] * gradient[2 * n + j];
    point.response_factor[i] = factor;
    point.response_displacement[i] = q;
    r -= displacement_of(_c.response(s, s, i), factor, q, n, basis);
  }
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    add_rest_response(s, i, r, 1, _c.response_basis(0, s, i), point.response_displacement[i]);
}

Vector Constraints::response_at(std::int32_t t, std::int32_t s) const {
  const Constraint& point = _c.point[s];
  Vector u = {};
  for (std::int32_t i = 0; i < point.n_nodes; ++i)
    u += displacement_of(_c.response(t, s, i), point.response_factor[i], point.response_displacement[i],
                         basis_size(_model, node(point, i)), _c.response_basis(0, s, i));
  return u;
}

void Constraints::add_derivatives(std::int32_t t, std::int32_t i) {
  const Constraint& point = _c.point[t];
  const ActiveNode& by = node(point, i);
  const std::int32_t n = basis_size(_model, by);
  const Matrix &to_q = point.node_contribution[i], &to_e = point.node_displacement[i];
  const Vector q = to_q * point.displacement, e = to_e * point.displacement;
  const double square = dot(e, e), factor = point.response_factor[i];
  // The gradient of the factor q . e / e . e by p.
  Vector factor_gradient = {};
  if (square > 0)
    factor_gradient =
        (transposed_times(to_q, e) + transposed_times(to_e, q) - (2 * factor) * transposed_times(to_e, e)) / square;
  const Matrix rest = to_q - factor * to_e - outer(e, factor_gradient);
  basis_and_gradient(_model, by, e.x, _c.basis, _c.gradient, _c.kernel_scratch);
  for (std::int32_t s = 0; s < n_quantities(); ++s) {
    const NodeField& local = _c.response(quantity(s), t, i);
    Matrix change = {};
    Vector value = local.constant;
    for (int r = 0; r < 3; ++r)
      for (std::int32_t j = 0; j < n; ++j) {
        const double weight = local.rows[r * n + j];
        value[r] += weight * _c.basis[j];
        for (int k = 0; k < 3; ++k) change(r, k) += weight * _c.gradient[k * n + j];
      }
    Matrix& sum = _c.derivative(quantity(s), t);
    sum += factor * (change * to_e) + outer(value, factor_gradient);
    sum += local.direct * to_q;
    sum += (_c.rest_response(quantity(s), t, i) - local.direct) * rest;
  }
}

void Constraints::find_derivatives(std::int32_t t) {
  for (std::int32_t s = 0; s < n_quantities(); ++s) _c.derivative(quantity(s), t) = {};
  for (std::int32_t i = 0; i < _c.point[t].n_nodes; ++i) add_derivatives(t, i);
  // The remaining displacement of the tool's point is added as in the undeformed body.
  const Matrix lacking = diagonal(1) - _c.derivative(t, t);
  for (std::int32_t s = 0; s < n_quantities(); ++s) _c.derivative(quantity(s), t) += rest_block(s, t) * lacking;
}

double Constraints::energy_of_nodes(const Constraint& point) const {
  double energy = 0;
  for (std::int32_t i = 0; i < point.n_nodes && _model.has_energy; ++i) {
    Vector force;
    double one = 0;
    evaluate_force(_model, node(point, i), (point.node_displacement[i] * point.displacement).x, force.x, &one, nullptr);
    energy += point.node_factor[i] * one;
  }
  return energy;
}

void Constraints::set_force(std::int32_t s) {
  Constraint& point = _c.point[s];
  const Vector linear = point.stiffness * point.displacement;
  double energy = dot(linear, point.displacement) / 2;
  point.force = linear;
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    const Vector e = point.node_displacement[i] * point.displacement, ke = point.node_stiffness[i] * e;
    Vector f;
    evaluate_force(_model, node(point, i), e.x, f.x);
    point.force += point.node_factor[i] * transposed_times(point.node_displacement[i], f - ke);
    energy -= point.node_factor[i] * dot(ke, e) / 2;
    // A single node follows the tool exactly, so that psi is 0.
    for (int g = 0; g < 3 && point.n_nodes > 1; ++g)
      energy -= add_coupling_force(s, i, e, linear, gauss_point[g], gauss_weight[g]);
  }
  point.energy = energy;
}

double Constraints::add_coupling_force(std::int32_t s, std::int32_t i, const Vector& e, const Vector& linear, double x,
                                       double w) {
  Constraint& point = _c.point[s];
  const ActiveNode& by = node(point, i);
  const NodeField& local = _c.response(s, s, i);
  const double* rest_gradient = _c.rest_gradient(0, s, i);
  const std::int32_t n = basis_size(_model, by);
  const Vector there = x * e;
  basis_and_gradient(_model, by, there.x, _c.basis, _c.gradient, _c.kernel_scratch);
  const Vector z = displacement_of(local, 1, there, n, _c.basis) - _c.rest_response(s, s, i) * there;
  // The transpose of dz/de, applied to A p.
  Vector dz_force = {};
  for (int r = 0; r < 3; ++r) {
    const double* row = local.rows + r * n;
    for (int k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::int32_t j = 0; j < n; ++j) sum += row[j] * (_c.gradient[k * n + j] - rest_gradient[k * n + j]);
      dz_force[k] += x * linear[r] * sum;
    }
  }
  point.force -=
      (w * point.node_factor[i]) * (point.stiffness * z + transposed_times(point.node_displacement[i], dz_force));
  return w * point.node_factor[i] * dot(linear, z);
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
  const std::size_t t = round ? 1 : static_cast<std::size_t>(c.max_tools), n_quantities = t > 1 ? 2 * t : 1,
                    n_sets = t > 1 ? 1 + t : 1, n_corners = static_cast<std::size_t>(c.n_corners) * t,
                    n_fields = n_corners * n_quantities;
  c.point = arena.take<Constraint>(t);
  c.field = {arena.take<FieldPart>(n_corners * n_sets), c.max_tools, c.n_corners};
  c.field_basis = {arena.take<double>(n_corners * n_sets, model.n_basis), c.max_tools, c.n_corners, model.n_basis};
  c.field_rotation = arena.take<Vector>(n_sets);
  c.kernel_scratch = arena.take<double>(3 * (static_cast<std::size_t>(model.shared.n_centers) + 3));
  c.response = {arena.take<NodeField>(n_fields), c.max_tools, c.n_corners};
  auto* rows = arena.take<double>(3 * model.n_basis, n_fields + 1);
  for (std::size_t i = 0; c.response.data && rows && i < n_fields; ++i)
    c.response.data[i].rows = rows + 3 * model.n_basis * i;
  c.pair_field.rows = rows ? rows + 3 * model.n_basis * n_fields : nullptr;
  c.rest_response = {arena.take<Matrix>(n_fields), c.max_tools, c.n_corners};
  c.rest_gradient = {arena.take<double>(3 * n_corners, model.n_basis), c.max_tools, c.n_corners, 3 * model.n_basis};
  c.response_basis = {arena.take<double>(n_corners, model.n_basis), c.max_tools, c.n_corners, model.n_basis};
  c.surface_rotation = arena.take<SurfaceRotation>(n_sets > 1);
  c.basis = arena.take<double>(model.n_basis);
  c.gradient = arena.take<double>(3 * model.n_basis);
  const auto n_shared = 3 * static_cast<std::size_t>(model.shared.n_modes);
  c.mode_scratch = arena.take<double>(n_shared > model.n_basis ? n_shared : model.n_basis);
  c.rest_matrix = arena.take<double>(9 * n_quantities * t);
  c.work = arena.take<double>(9 * t * t);
  c.vectors = arena.take<double>(9 * t * t);
  c.stiffness = {arena.take<Matrix>(t * t), c.max_tools};
  c.derivative = {arena.take<Matrix>(n_quantities * t), c.max_tools};
  c.residual = {arena.take<Vector>(t * t), c.max_tools};
  c.multiplier = {arena.take<Vector>(t * t), c.max_tools};
  c.residual_rotation = {arena.take<Vector>(t * t), c.max_tools};
  c.correction = arena.take<Vector>(t);
  c.forces = arena.take<Vector>(t);
  c.single_force = arena.take<Vector>(t);
  c.energy = arena.take<double>(t);
  c.weight = arena.take<double>(t);
  if (made != nullptr && !arena.overflow()) *made = c;
  return made;
}

void coupled_field(const phn_model& model, const Coupling& c, PreparedNodes& prepared, double* scratch, double* one,
                   double* field) {
  for (std::int32_t set = 0; set < c.n_sets; ++set)
    for (std::int32_t s = 0; s < c.n_tools; ++s) {
      const Constraint& point = c.point[s];
      for (std::int32_t i = 0; i < point.n_nodes; ++i) {
        const FieldPart& part = c.field(set, s, i);
        field_of_basis(model, model.active[point.active[i]], prepare(model, prepared, point.active[i]), part.factor,
                       part.displacement.x, c.field_basis(set, s, i), scratch, one);
        for (std::int32_t o = 0; o < model.n_output; ++o) {
          const Vector turned = rotated(c.field_rotation[set], vector_at(one + 3 * o));
          for (int k = 0; k < 3; ++k) field[3 * o + k] += turned[k];
        }
      }
    }
}

}  // namespace PHN_RUNTIME
