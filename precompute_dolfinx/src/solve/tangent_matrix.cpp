#include "tangent_matrix.hpp"

#include <algorithm>

namespace phynness {
TangentMatrix::TangentMatrix(Discretization& body, const std::vector<std::int32_t>& fixed_dofs) {
  _unknown_of.assign(body.n_dofs(), 0);
  for (const auto dof : fixed_dofs) _unknown_of[dof] = -1;
  for (int dof = 0; dof < body.n_dofs(); ++dof)
    if (_unknown_of[dof] == 0) {
      _unknown_of[dof] = static_cast<std::int32_t>(_dof_of.size());
      _dof_of.push_back(dof);
    }

  const int n = n_unknowns();
  std::vector<std::vector<PetscInt>> rows(n);
  for (int i = 0; i < n; ++i) rows[i].push_back(i);
  for (int block = 0; block < body.n_blocks(); ++block) {
    const auto dofs = body.block_dofs(block);
    for (const auto a : dofs)
      if (const auto i = _unknown_of[a]; i >= 0)
        for (const auto b : dofs)
          if (const auto j = _unknown_of[b]; j >= 0) rows[i].push_back(j);
  }
  _stiffness_pattern = pattern_of(std::move(rows));
  for (int block = 0; block < body.n_blocks(); ++block) {
    const auto dofs = body.block_dofs(block);
    _block_start.push_back(_position.size());
    for (const auto a : dofs)
      for (const auto b : dofs) {
        const auto i = _unknown_of[a], j = _unknown_of[b];
        _position.push_back(i < 0 || j < 0 ? -1 : _stiffness_pattern.position(i, j));
      }
  }
  _matrix_pattern = _stiffness_pattern;
  _dependent_of.assign(n, -1);
  create_matrix();
}

TangentMatrix::Pattern TangentMatrix::pattern_of(std::vector<std::vector<PetscInt>> rows) {
  Pattern pattern;
  pattern.row_start.push_back(0);
  for (auto& row : rows) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    pattern.column.insert(pattern.column.end(), row.begin(), row.end());
    pattern.row_start.push_back(static_cast<PetscInt>(pattern.column.size()));
  }
  return pattern;
}

std::int32_t TangentMatrix::Pattern::position(PetscInt i, PetscInt j) const {
  const auto first = column.begin() + row_start[i], last = column.begin() + row_start[i + 1];
  return static_cast<std::int32_t>(std::lower_bound(first, last, j) - column.begin());
}

void TangentMatrix::create_matrix() {
  _matrix = {};
  _exact = {};
  const int n = n_unknowns();
  const std::vector<PetscScalar> zeros(_matrix_pattern.size(), 0.0);
  PHYNNESS_PETSC(MatCreate(PETSC_COMM_SELF, _matrix.address()));
  PHYNNESS_PETSC(MatSetSizes(_matrix, n, n, n, n));
  PHYNNESS_PETSC(MatSetType(_matrix, MATSEQAIJ));
  PHYNNESS_PETSC(MatSeqAIJSetPreallocationCSR(_matrix, _matrix_pattern.row_start.data(), _matrix_pattern.column.data(),
                                              zeros.data()));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRIC, PETSC_TRUE));
  PHYNNESS_PETSC(MatSetOption(_matrix, MAT_SYMMETRY_ETERNAL, PETSC_TRUE));
}

bool TangentMatrix::constrain(const Constraint& constraint) {
  const bool had_masters = _has_masters;
  _G = constraint.G;
  _has_masters = !constraint.masters.empty();
  _dependent.clear();
  _dependent_of.assign(_dependent_of.size(), -1);
  for (std::size_t c = 0; c < constraint.dofs.size(); ++c) {
    Dependent dependent{_unknown_of[constraint.dofs[c]], {}};
    for (std::size_t m = 0; m < constraint.masters.size(); ++m)
      if (const double factor = constraint.M(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(m)); factor != 0)
        dependent.masters.emplace_back(_unknown_of[constraint.masters[m]], factor);
    _dependent_of[dependent.unknown] = static_cast<std::int32_t>(c);
    _dependent.push_back(std::move(dependent));
  }
  if (!had_masters && !_has_masters) {
    find_condensed_terms();
    return false;
  }
  _matrix_pattern = _stiffness_pattern;
  if (_has_masters) {
    std::vector<std::vector<PetscInt>> rows(n_unknowns());
    for (int i = 0; i < n_unknowns(); ++i)
      rows[i].assign(_stiffness_pattern.column.begin() + _stiffness_pattern.row_start[i],
                     _stiffness_pattern.column.begin() + _stiffness_pattern.row_start[i + 1]);
    for (const auto& dependent : _dependent)
      for (auto k = _stiffness_pattern.row_start[dependent.unknown];
           k < _stiffness_pattern.row_start[dependent.unknown + 1]; ++k) {
        const auto j = _stiffness_pattern.column[k];
        for (const auto& [i, factor] : dependent.masters) {
          if (_dependent_of[j] < 0) {
            rows[i].push_back(j);
            rows[j].push_back(i);
          } else {
            for (const auto& other : _dependent[_dependent_of[j]].masters) rows[i].push_back(other.first);
          }
        }
      }
    _matrix_pattern = pattern_of(std::move(rows));
  }
  find_condensed_terms();
  create_matrix();
  return true;
}

bool TangentMatrix::is_finite() const {
  const PetscScalar* values = nullptr;
  PHYNNESS_PETSC(MatSeqAIJGetArrayRead(_matrix, &values));
  const bool finite =
      Eigen::Map<const Eigen::VectorXd>(values, static_cast<Eigen::Index>(_matrix_pattern.size())).allFinite();
  PHYNNESS_PETSC(MatSeqAIJRestoreArrayRead(_matrix, &values));
  return finite;
}

TangentMatrix::Coupling TangentMatrix::assemble(Discretization& body, std::span<const double> state,
                                                Convexity convexity) {
  const bool convex = convexity != Convexity::none;
  _stiffness.assign(_stiffness_pattern.size(), 0.0);
  if (convex) _convex_stiffness.assign(_stiffness_pattern.size(), 0.0);
  body.block_tangents(state, convexity,
                      [&](std::int32_t block, std::span<const double> exact, std::span<const double> nearest) {
                        const std::int32_t* position = _position.data() + _block_start[block];
                        for (std::size_t e = 0; e < exact.size(); ++e)
                          if (position[e] >= 0) _stiffness[position[e]] += exact[e];
                        if (!convex) return;
                        for (std::size_t e = 0; e < nearest.size(); ++e)
                          if (position[e] >= 0) _convex_stiffness[position[e]] += nearest[e];
                      });
  const Coupling contributions = coupling(_stiffness);
  if (convex && !_exact) PHYNNESS_PETSC(MatDuplicate(_matrix, MAT_DO_NOT_COPY_VALUES, _exact.address()));
  condense_into(_stiffness, convex ? _exact : _matrix);
  if (convex) condense_into(_convex_stiffness, _matrix);
  return contributions;
}

TangentMatrix::Coupling TangentMatrix::coupling(const std::vector<double>& K) const {
  const auto n_parameters = _G.cols();
  Coupling coupling{Eigen::MatrixXd::Zero(n_unknowns(), n_parameters),
                    Eigen::MatrixXd::Zero(n_parameters, n_parameters)};
  for (std::size_t c = 0; c < _dependent.size(); ++c) {
    const auto g = _G.row(static_cast<Eigen::Index>(c));
    const auto row = _dependent[c].unknown;
    for (auto k = _stiffness_pattern.row_start[row]; k < _stiffness_pattern.row_start[row + 1];
         ++k) {  // by symmetry also a column
      const auto j = _stiffness_pattern.column[k], other = _dependent_of[j];
      if (other < 0) {
        coupling.columns.row(j) += K[k] * g;
        continue;
      }
      coupling.corner += K[k] * _G.row(other).transpose() * g;
      for (const auto& [i, factor] : _dependent[other].masters) coupling.columns.row(i) += K[k] * factor * g;
    }
  }
  return coupling;
}

void TangentMatrix::find_condensed_terms() {
  _matrix_position.clear();
  _condensed_terms.clear();
  _zero_positions.clear();
  _unit_positions.clear();
  if (_has_masters)
    for (int i = 0; i < n_unknowns(); ++i)
      for (auto k = _stiffness_pattern.row_start[i], at = _matrix_pattern.row_start[i];
           k < _stiffness_pattern.row_start[i + 1]; ++k) {
        while (_matrix_pattern.column[at] != _stiffness_pattern.column[k]) ++at;
        _matrix_position.push_back(at);
      }
  for (const auto& dependent : _dependent)
    for (auto k = _stiffness_pattern.row_start[dependent.unknown];
         k < _stiffness_pattern.row_start[dependent.unknown + 1]; ++k) {
      const auto j = _stiffness_pattern.column[k];
      for (const auto& [i, factor] : dependent.masters) {
        if (_dependent_of[j] < 0) {
          _condensed_terms.push_back({k, _matrix_pattern.position(i, j), factor, 1});
          _condensed_terms.push_back({k, _matrix_pattern.position(j, i), factor, 1});
        } else {
          for (const auto& [other, other_factor] : _dependent[_dependent_of[j]].masters)
            _condensed_terms.push_back({k, _matrix_pattern.position(i, other), factor, other_factor});
        }
      }
    }
  for (const auto& dependent : _dependent) {
    const auto c = dependent.unknown;
    for (auto k = _matrix_pattern.row_start[c]; k < _matrix_pattern.row_start[c + 1]; ++k) {
      if (_matrix_pattern.column[k] == c) {
        _unit_positions.push_back(k);
      } else {
        _zero_positions.push_back(k);
        _zero_positions.push_back(_matrix_pattern.position(_matrix_pattern.column[k], c));
      }
    }
  }
}

void TangentMatrix::condense_into(const std::vector<double>& K, Mat matrix) const {
  PetscScalar* values = nullptr;
  PHYNNESS_PETSC(MatSeqAIJGetArray(matrix, &values));
  if (!_has_masters) {
    std::copy(K.begin(), K.end(), values);
  } else {
    std::fill_n(values, _matrix_pattern.size(), 0.0);
    for (std::size_t k = 0; k < K.size(); ++k) values[_matrix_position[k]] = K[k];
  }
  for (const auto& term : _condensed_terms)
    values[term.matrix_position] += term.factor * K[term.stiffness_position] * term.other_factor;
  for (const auto k : _zero_positions) values[k] = 0;
  for (const auto k : _unit_positions) values[k] = 1;
  PHYNNESS_PETSC(MatSeqAIJRestoreArray(matrix, &values));
  PHYNNESS_PETSC(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PHYNNESS_PETSC(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

}  // namespace phynness
