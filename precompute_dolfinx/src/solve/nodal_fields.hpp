// Scalar fields of a state: means over cells, and values at nodes computed from them.
#pragma once

#include <Eigen/Core>
#include <phynness/formats/fields.hpp>
#include <span>
#include <vector>

#include "discretization.hpp"

namespace phynness {

class NodalFields {
 public:
  NodalFields(const Discretization& body, std::vector<Field> fields);

  /// Means over the cells in units of Scaling::modulus_Pa: the integral of the field by the element's quadrature rule,
  /// divided by the volume at rest. At equilibrium the sum of energy density times volume is Discretization::energy
  /// (forms/mechanics.py, mixed()).
  /// @return n_cells x n_fields
  Eigen::MatrixXd in_cells(const Discretization& body, std::span<const double> state) const;

  /// Values at nodes: the average of the cells around a node, weighted by their volumes at rest.
  /// @return n_nodes x n_fields, in units of Scaling::modulus_Pa
  Eigen::MatrixXd at_nodes(const Discretization& body, std::span<const double> state) const;

 private:
  std::vector<Field> _fields;
  std::vector<double> _volume;       ///< of each cell
  Eigen::VectorXd _volume_at_nodes;  ///< sum over the cells of each node
};

}  // namespace phynness
