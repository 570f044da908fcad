#include "tools/coupled_field.hpp"

#include <cmath>

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {

void CoupledField::clear_field() {
  for (std::int32_t set = 0; set < _c.n_sets; ++set) {
    _c.field_turn[set] = {};
    for (std::int32_t i = 0; i < _c.n_corners * _c.n_tools; ++i) field(set, 0, i) = {};
    set_zero(field_basis(set, 0, 0), basis_of_set());
  }
}

void CoupledField::add_response(std::int32_t set, std::int32_t s, double weight) {
  const Constraint& point = _c.point[s];
  for (std::int32_t i = 0; i < point.n_nodes; ++i) {
    field(set, s, i).share += weight * point.response_share[i];
    field(set, s, i).own += weight * point.response_own[i];
    add_scaled(weight, response_basis(s, i), basis_size(_model, node(point, i)), field_basis(set, s, i));
  }
}

void CoupledField::add_at_rest(std::int32_t set, std::int32_t s, const Vector& r, double weight) {
  for (std::int32_t i = 0; i < _c.point[s].n_nodes; ++i)
    move_at_rest(s, i, r, weight, field_basis(set, s, i), field(set, s, i).own);
}

double CoupledField::constraint_residual() {
  double largest = 0;
  for (std::int32_t t = 0; t < _c.n_tools; ++t) {
    _c.right[t] = _targets[t];
    for (std::int32_t set = 0; set < _c.n_sets; ++set) {
      Vector sum = {};
      for (std::int32_t s = 0; s < _c.n_tools; ++s) {
        const Constraint& point = _c.point[s];
        for (std::int32_t i = 0; i < point.n_nodes; ++i)
          sum += displacement_of(_c.displacement[at(t, s, i)], field(set, s, i).share, field(set, s, i).own,
                                 basis_size(_model, node(point, i)), field_basis(set, s, i));
      }
      _c.right[t] -= rotated(_c.field_turn[set], sum);
    }
    largest = std::fmax(largest, length(_c.right[t].x));
  }
  return largest;
}

bool CoupledField::finite() const {
  bool all = true;
  for (std::int32_t t = 0; t < _c.n_tools; ++t) all = all && is_finite(_c.point[t].force) && is_finite(_c.point[t].own);
  for (std::int32_t set = 0; set < _c.n_sets; ++set) {
    all = all && is_finite(_c.field_turn[set]);
    for (std::int32_t i = 0; i < _c.n_corners * _c.n_tools; ++i) all = all && is_finite(field(set, 0, i).own);
    all = all && all_finite(field_basis(set, 0, 0), basis_of_set());
  }
  return all;
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
