// The tangent on the dofs that are not fixed, in one sparsity pattern for all probes.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "constraint.hpp"
#include "discretization.hpp"
#include "petsc_check.hpp"

namespace phynness {

/// How much an element tangent loses of its negative eigenvalues: nothing, what is large beside its trace (a
/// thousandth; quick to see), or all.
enum class Convexity { none, nearly, strictly };

/// Rows are the dofs that are not fixed, "unknowns". A probe's prescribed dofs stay as rows of the identity,
/// so that the pattern, and with it the symbolic factorization, is the same for every active node.
class TangentMatrix {
 public:
  TangentMatrix(Discretization& body, const std::vector<std::int32_t>& fixed_dofs);

  int n_unknowns() const { return static_cast<int>(_dof_of.size()); }
  /// Dof of an unknown, and unknown of a dof (-1: fixed).
  const std::vector<std::int32_t>& dof_of() const { return _dof_of; }
  const std::vector<std::int32_t>& unknown_of() const { return _unknown_of; }
  Mat matrix() const { return _matrix; }
  /// Of matrix(). MUMPS would take a NaN for a pivot like any other.
  bool is_finite() const;
  /// K(state) as it is, after an assembly that made matrix() convex.
  Mat exact() const { return _exact; }

  /// What the prescribed unknowns contributed before their rows and columns became the identity's.
  struct Coupling {
    Eigen::MatrixXd columns;  ///< n_unknowns x n_parameters: K_fc G, zero in prescribed rows
    Eigen::MatrixXd corner;   ///< n_parameters^2: G^T K_cc G
  };

  /// Assembles K(state) into matrix(), prescribed rows and columns replaced by the identity.
  /// @param prescribed  unknowns of constraint.dofs, in that order
  /// @param convexity   unless none, matrix() is made of element tangents whose block of the displacements is
  /// the nearest positive semidefinite one; exact() of the true ones
  Coupling assemble(Discretization& body, std::span<const double> state, const Constraint& constraint,
                    const std::vector<std::int32_t>& prescribed, Convexity convexity = Convexity::none);

 private:
  void prescribe(PetscScalar* values, const std::vector<std::int32_t>& prescribed) const;

  PetscMat _matrix, _exact;
  std::vector<std::int32_t> _dof_of, _unknown_of;
  std::vector<PetscInt> _row_start, _column;
  std::vector<std::int32_t> _position;    ///< per cell and entry of its element matrix: where in the values, or -1
  std::vector<std::int32_t> _transposed;  ///< per stored entry (i,j): where (j,i) is
};

}  // namespace phynness
