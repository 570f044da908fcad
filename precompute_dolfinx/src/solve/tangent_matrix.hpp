// The tangent of all dofs that are not fixed, under the constraint of the tools.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "constraint.hpp"
#include "discretization.hpp"
#include "petsc_check.hpp"

namespace phynness {

/// The rows are the unknowns, which are the dofs that are not fixed. Dependent dofs of a constraint are rows of the
/// identity, so that all constraints without masters share the pattern and the symbolic factorization. A constraint
/// with masters has its own pattern, in which the masters and their neighbours are a dense block.
class TangentMatrix {
 public:
  TangentMatrix(Discretization& body, const std::vector<std::int32_t>& fixed_dofs);

  int n_unknowns() const { return static_cast<int>(_dof_of.size()); }
  /// The dof of each unknown, and the unknown of each dof (-1: fixed).
  const std::vector<std::int32_t>& dof_of() const { return _dof_of; }
  const std::vector<std::int32_t>& unknown_of() const { return _unknown_of; }
  Mat matrix() const { return _matrix; }
  /// Whether matrix() is finite. A factorization would use a NaN as a pivot.
  bool is_finite() const;
  /// The unmodified K(state) after an assembly of a convex matrix().
  Mat exact() const { return _exact; }

  /// Sets the constraint of later assemblies.
  /// @return true if matrix() is another object, with another pattern
  bool constrain(const Constraint& constraint);

  /// Contributions of the parameters of the constraint.
  struct Coupling {
    Eigen::MatrixXd columns;  ///< n_unknowns x n_parameters: (K_fc + M^T K_cc) G, zero in dependent rows
    Eigen::MatrixXd corner;   ///< n_parameters^2: G^T K_cc G
  };

  /// Assembles T^T K(state) T into matrix(), where T expresses all dofs by those that are not dependent; dependent rows
  /// and columns are those of the identity.
  /// @param convexity   unless `none`, matrix() is assembled from element tangents whose displacement block is replaced
  ///                    by the nearest positive semidefinite one, and exact() from the true element tangents
  Coupling assemble(Discretization& body, std::span<const double> state, Convexity convexity = Convexity::none);

 private:
  struct Pattern {
    std::vector<PetscInt> row_start, column;
    std::int32_t position(PetscInt i, PetscInt j) const;  ///< position of a stored entry
    std::size_t size() const { return column.size(); }
  };
  /// @param rows  columns of each row, in any order and with repeats
  static Pattern pattern_of(std::vector<std::vector<PetscInt>> rows);
  void create_matrix();
  Coupling coupling(const std::vector<double>& K) const;
  /// Finds the positions in matrix() to which the entries of K contribute.
  void find_condensed_terms();
  /// Stores T^T K T, with rows of the identity, in the values of a matrix.
  void condense_into(const std::vector<double>& K, Mat matrix) const;

  PetscMat _matrix, _exact;
  std::vector<std::int32_t> _dof_of, _unknown_of;
  Pattern _stiffness_pattern;             ///< pattern of K
  Pattern _matrix_pattern;                ///< pattern of matrix()
  std::vector<std::int32_t> _position;    ///< per block and entry of its tangent: position in the values, or -1
  std::vector<std::size_t> _block_start;  ///< start of each block in _position
  std::vector<double> _stiffness, _convex_stiffness;  ///< values of K
  Eigen::MatrixXd _G;
  /// A dependent unknown and its masters with their factors.
  struct Dependent {
    std::int32_t unknown;
    std::vector<std::pair<std::int32_t, double>> masters;
  };
  std::vector<Dependent> _dependent;
  std::vector<std::int32_t> _dependent_of;  ///< per unknown: position in _dependent, or -1
  bool _has_masters = false;
  std::vector<std::int32_t> _matrix_position;  ///< per entry of K: position in matrix(); empty without masters
  /// A product of factors of masters and an entry of K, and the position to which it is added.
  struct CondensedTerm {
    std::int32_t stiffness_position, matrix_position;
    double factor, other_factor;
  };
  std::vector<CondensedTerm> _condensed_terms;
  std::vector<std::int32_t> _zero_positions, _unit_positions;  ///< positions in dependent rows and columns
};

}  // namespace phynness
