// The tangent of all dofs that are not fixed, with the same sparsity pattern for all probes.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "constraint.hpp"
#include "discretization.hpp"
#include "petsc_check.hpp"

namespace phynness {

/// The negative eigenvalues that are removed from an element tangent: none, those larger than a thousandth of its trace
/// (which can be detected quickly), or all.
enum class Convexity { none, nearly, strictly };

/// Rows are the dofs that are not fixed, the "unknowns". Prescribed dofs of a probe remain as rows of the identity, so
/// that the pattern and the symbolic factorization are the same for every active node.
class TangentMatrix {
 public:
  TangentMatrix(Discretization& body, const std::vector<std::int32_t>& fixed_dofs);

  int n_unknowns() const { return static_cast<int>(_dof_of.size()); }
  /// The dof of each unknown, and the unknown of each dof (-1: fixed).
  const std::vector<std::int32_t>& dof_of() const { return _dof_of; }
  const std::vector<std::int32_t>& unknown_of() const { return _unknown_of; }
  Mat matrix() const { return _matrix; }
  /// Whether matrix() is finite. MUMPS would use a NaN as a pivot.
  bool is_finite() const;
  /// The unmodified K(state), after an assembly in which matrix() was made convex.
  Mat exact() const { return _exact; }

  /// Contributions of the prescribed unknowns before their rows and columns are replaced by those of the identity.
  struct Coupling {
    Eigen::MatrixXd columns;  ///< n_unknowns x n_parameters: K_fc G, zero in prescribed rows
    Eigen::MatrixXd corner;   ///< n_parameters^2: G^T K_cc G
  };

  /// Assembles K(state) into matrix() and replaces prescribed rows and columns by those of the identity.
  /// @param prescribed  unknowns of constraint.dofs, in their order
  /// @param convexity   unless `none`, matrix() is assembled from element tangents whose displacement block is replaced
  ///                    by the nearest positive semidefinite one, and exact() from the true element tangents
  Coupling assemble(Discretization& body, std::span<const double> state, const Constraint& constraint,
                    const std::vector<std::int32_t>& prescribed, Convexity convexity = Convexity::none);

 private:
  void prescribe(PetscScalar* values, const std::vector<std::int32_t>& prescribed) const;

  PetscMat _matrix, _exact;
  std::vector<std::int32_t> _dof_of, _unknown_of;
  std::vector<PetscInt> _row_start, _column;
  std::vector<std::int32_t> _position;    ///< per cell and entry of its element matrix: position in the values, or -1
  std::vector<std::int32_t> _transposed;  ///< per stored entry (i,j): position of (j,i)
};

}  // namespace phynness
