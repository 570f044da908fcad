#include "nodal_fields.hpp"

#include <cassert>

namespace phynness {

NodalFields::NodalFields(const Discretization& body, std::vector<Field> fields) : _fields(std::move(fields)) {
  if (_fields.empty()) return;
  _volume_at_nodes.setZero(body.n_nodes());
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    _volume.push_back(body.cell_volume(cell));
    for (const auto node : body.cell_nodes(cell)) _volume_at_nodes[node] += _volume.back();
  }
}

Eigen::MatrixXd NodalFields::in_cells(const Discretization& body, std::span<const double> state) const {
  Eigen::MatrixXd means(body.n_cells(), static_cast<Eigen::Index>(_fields.size()));
  for (std::size_t f = 0; f < _fields.size(); ++f) {
    assert(body.forms().fields[static_cast<std::size_t>(_fields[f])]);  // shells have no fields and are refused earlier
    auto mean = means.col(static_cast<Eigen::Index>(f));
    body.field_integrals(_fields[f], state, {mean.data(), static_cast<std::size_t>(mean.size())});
    for (int cell = 0; cell < body.n_cells(); ++cell) mean[cell] /= _volume[static_cast<std::size_t>(cell)];
  }
  return means;
}

Eigen::MatrixXd NodalFields::at_nodes(const Discretization& body, std::span<const double> state) const {
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(body.n_nodes(), static_cast<Eigen::Index>(_fields.size()));
  if (_fields.empty()) return values;
  const Eigen::MatrixXd means = in_cells(body, state);
  for (int cell = 0; cell < body.n_cells(); ++cell)
    for (const auto node : body.cell_nodes(cell))
      values.row(node) += _volume[static_cast<std::size_t>(cell)] * means.row(cell);
  return _volume_at_nodes.cwiseInverse().asDiagonal() * values;
}

}  // namespace phynness
