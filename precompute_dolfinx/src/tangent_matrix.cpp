#include "tangent_matrix.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "fault_injection.hpp"

namespace phynness {
namespace {

/// Replaces negative eigenvalues of a matrix by zero (Teran et al. 2005, doi:10.1145/1073368.1073394).
/// @return true if there were negative eigenvalues
template <typename Matrix>
bool make_convex(Matrix& matrix, Convexity convexity) {
  // A Cholesky factorization, which takes a twentieth of the time of an eigenvalue decomposition, shows whether there
  // are negative eigenvalues. The shift accepts rigid motions, whose eigenvalues are zero up to rounding.
  Matrix shifted = matrix;
  shifted.diagonal().array() += 1e-3 * matrix.trace();
  if (convexity == Convexity::nearly && Eigen::LLT<Matrix>(shifted).info() == Eigen::Success) return false;
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(matrix);
  if (eigen.info() != Eigen::Success || eigen.eigenvalues()[0] >= 0) return false;
  Eigen::Index n = 0;
  while (n < matrix.rows() && eigen.eigenvalues()[n] < 0) ++n;
  // Usually there are few negative eigenvalues, which are subtracted.
  matrix -= eigen.eigenvectors().leftCols(n) * eigen.eigenvalues().head(n).asDiagonal() *
            eigen.eigenvectors().leftCols(n).transpose();
  return true;
}

}  // namespace

TangentMatrix::TangentMatrix(Discretization& body, const std::vector<std::int32_t>& fixed_dofs) {
  _unknown_of.assign(body.n_dofs(), 0);
  for (const auto dof : fixed_dofs) _unknown_of[dof] = -1;
  for (int dof = 0; dof < body.n_dofs(); ++dof)
    if (_unknown_of[dof] == 0) {
      _unknown_of[dof] = static_cast<std::int32_t>(_dof_of.size());
      _dof_of.push_back(dof);
    }

  const int n = n_unknowns(), m = body.n_element_dofs();
  std::vector<std::vector<PetscInt>> rows(n);
  for (int i = 0; i < n; ++i) rows[i].push_back(i);
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    const auto dofs = body.element_dofs(cell);
    for (const auto a : dofs)
      if (const auto i = _unknown_of[a]; i >= 0)
        for (const auto b : dofs)
          if (const auto j = _unknown_of[b]; j >= 0) rows[i].push_back(j);
  }
  _row_start.assign(n + 1, 0);
  for (int i = 0; i < n; ++i) {
    std::sort(rows[i].begin(), rows[i].end());
    rows[i].erase(std::unique(rows[i].begin(), rows[i].end()), rows[i].end());
    _column.insert(_column.end(), rows[i].begin(), rows[i].end());
    _row_start[i + 1] = static_cast<PetscInt>(_column.size());
  }
  const auto position = [&](PetscInt i, PetscInt j) {
    const auto first = _column.begin() + _row_start[i], last = _column.begin() + _row_start[i + 1];
    return static_cast<std::int32_t>(std::lower_bound(first, last, j) - _column.begin());
  };
  _transposed.resize(_column.size());
  for (int i = 0; i < n; ++i)
    for (auto k = _row_start[i]; k < _row_start[i + 1]; ++k) _transposed[k] = position(_column[k], i);
  _position.reserve(static_cast<std::size_t>(body.n_cells()) * m * m);
  for (int cell = 0; cell < body.n_cells(); ++cell) {
    const auto dofs = body.element_dofs(cell);
    for (const auto a : dofs)
      for (const auto b : dofs) {
        const auto i = _unknown_of[a], j = _unknown_of[b];
        _position.push_back(i < 0 || j < 0 ? -1 : position(i, j));
      }
  }

  const std::vector<PetscScalar> zeros(_column.size(), 0.0);
  PHYNNESS_PETSC(MatCreate(PETSC_COMM_SELF, _matrix.address()));
  PHYNNESS_PETSC(MatSetSizes(_matrix, n, n, n, n));
  PHYNNESS_PETSC(MatSetType(_matrix, MATSEQAIJ));
  PHYNNESS_PETSC(MatSeqAIJSetPreallocationCSR(_matrix, _row_start.data(), _column.data(), zeros.data()));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
}

bool TangentMatrix::is_finite() const {
  const PetscScalar* values = nullptr;
  PHYNNESS_PETSC(MatSeqAIJGetArrayRead(_matrix, &values));
  const bool finite = Eigen::Map<const Eigen::VectorXd>(values, static_cast<Eigen::Index>(_column.size())).allFinite();
  PHYNNESS_PETSC(MatSeqAIJRestoreArrayRead(_matrix, &values));
  return finite;
}

TangentMatrix::Coupling TangentMatrix::assemble(Discretization& body, std::span<const double> state,
                                                const Constraint& constraint,
                                                const std::vector<std::int32_t>& prescribed, Convexity convexity) {
  const bool convex = convexity != Convexity::none;
  PetscScalar *values = nullptr, *convex_values = nullptr;
  if (convex && !_exact) PHYNNESS_PETSC(MatDuplicate(_matrix, MAT_DO_NOT_COPY_VALUES, _exact.address()));
  PHYNNESS_PETSC(MatSeqAIJGetArray(convex ? _exact : _matrix, &values));
  std::fill_n(values, _column.size(), 0.0);
  if (convex) {
    PHYNNESS_PETSC(MatSeqAIJGetArray(_matrix, &convex_values));
    std::fill_n(convex_values, _column.size(), 0.0);
  }
  using Fixed = Eigen::Matrix<double, 12, 12>;
  const int m = body.n_element_dofs();
  // Only the block of the displacements, which come first, is made convex.
  const int n_u = m - (body.pressure_dofs().empty() ? 0 : 4);
  Fixed linear;
  Eigen::MatrixXd quadratic, nearest;
  const auto per_cell = static_cast<std::size_t>(m) * m;
  body.element_tangents(state, [&](std::int32_t cell, std::span<const double> element) {
    const std::int32_t* position = _position.data() + per_cell * cell;
    for (std::size_t e = 0; e < per_cell; ++e)
      if (position[e] >= 0) values[position[e]] += element[e];
    if (!convex) return;
    nearest = Eigen::Map<const Eigen::MatrixXd>(element.data(), m, m);
    if (n_u == 12) {
      linear = nearest.topLeftCorner<12, 12>();
      if (make_convex(linear, convexity)) nearest.topLeftCorner<12, 12>() = linear;
    } else {
      quadratic = nearest.topLeftCorner(n_u, n_u);
      if (make_convex(quadratic, convexity)) nearest.topLeftCorner(n_u, n_u) = quadratic;
    }
    for (std::size_t e = 0; e < per_cell; ++e)
      if (position[e] >= 0) convex_values[position[e]] += nearest.data()[e];
  });

  // The contributions of prescribed rows are kept before these rows are replaced by those of the identity. By symmetry
  // a row is also the column.
  const int n_parameters = constraint.n_parameters();
  Coupling coupling{Eigen::MatrixXd::Zero(n_unknowns(), n_parameters),
                    Eigen::MatrixXd::Zero(n_parameters, n_parameters)};
  std::vector<std::int32_t> row_in_G(n_unknowns(), -1);
  for (std::size_t c = 0; c < prescribed.size(); ++c) row_in_G[prescribed[c]] = static_cast<std::int32_t>(c);
  for (std::size_t c = 0; c < prescribed.size(); ++c) {
    const auto g = constraint.G.row(static_cast<Eigen::Index>(c));
    for (auto k = _row_start[prescribed[c]]; k < _row_start[prescribed[c] + 1]; ++k) {
      const auto j = _column[k];
      if (row_in_G[j] >= 0)
        coupling.corner += values[k] * constraint.G.row(row_in_G[j]).transpose() * g;
      else
        coupling.columns.row(j) += values[k] * g;
    }
  }
  prescribe(values, prescribed);
  if (injected_fault(FaultSite::tangent) == Fault::not_finite)
    (convex ? convex_values : values)[_column.size() / 2] = std::nan("");
  PHYNNESS_PETSC(MatSeqAIJRestoreArray(convex ? _exact : _matrix, &values));
  if (convex) {
    prescribe(convex_values, prescribed);
    PHYNNESS_PETSC(MatSeqAIJRestoreArray(_matrix, &convex_values));
    PHYNNESS_PETSC(MatAssemblyBegin(_exact, MAT_FINAL_ASSEMBLY));
    PHYNNESS_PETSC(MatAssemblyEnd(_exact, MAT_FINAL_ASSEMBLY));
  }
  PHYNNESS_PETSC(MatAssemblyBegin(_matrix, MAT_FINAL_ASSEMBLY));
  PHYNNESS_PETSC(MatAssemblyEnd(_matrix, MAT_FINAL_ASSEMBLY));
  return coupling;
}

void TangentMatrix::prescribe(PetscScalar* values, const std::vector<std::int32_t>& prescribed) const {
  for (const auto c : prescribed)
    for (auto k = _row_start[c]; k < _row_start[c + 1]; ++k) {
      const double identity = _column[k] == c ? 1.0 : 0.0;
      values[k] = identity;
      values[_transposed[k]] = identity;
    }
}

}  // namespace phynness
