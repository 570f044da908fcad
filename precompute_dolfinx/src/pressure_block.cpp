#include "pressure_block.hpp"

#include <algorithm>

namespace phynness {

void PressureBlock::set(Mat tangent) {
  if (empty()) return;
  PetscInt n = 0;
  const PetscInt *row_start = nullptr, *column = nullptr;
  const PetscScalar* values = nullptr;
  PetscBool done = PETSC_FALSE;
  PHYNNESS_PETSC(MatGetRowIJ(tangent, 0, PETSC_FALSE, PETSC_FALSE, &n, &row_start, &column, &done));
  if (_position.empty()) {
    std::vector<std::int32_t> row_of(static_cast<std::size_t>(n), -1);
    for (std::size_t i = 0; i < _unknowns.size(); ++i) row_of[_unknowns[i]] = static_cast<std::int32_t>(i);
    std::vector<Eigen::Triplet<double, std::int32_t>> pattern;
    for (const auto i : _unknowns)
      for (auto k = row_start[i]; k < row_start[i + 1]; ++k)
        if (row_of[column[k]] >= 0) pattern.emplace_back(row_of[i], row_of[column[k]], k);
    const auto size = static_cast<Eigen::Index>(_unknowns.size());
    Eigen::SparseMatrix<double> position(size, size);  // positions are exact as doubles
    position.setFromTriplets(pattern.begin(), pattern.end());
    _position.assign(position.valuePtr(), position.valuePtr() + position.nonZeros());
    _block = std::move(position);
  }
  PHYNNESS_PETSC(MatRestoreRowIJ(tangent, 0, PETSC_FALSE, PETSC_FALSE, &n, &row_start, &column, &done));
  PHYNNESS_PETSC(MatSeqAIJGetArrayRead(tangent, &values));
  std::transform(_position.begin(), _position.end(), _block.valuePtr(), [&](auto k) { return -values[k]; });
  PHYNNESS_PETSC(MatSeqAIJRestoreArrayRead(tangent, &values));
  _is_new = true;
}

void PressureBlock::forget() {
  if (_factors) _spare = std::move(_factors);
  _is_new = false;
}

bool PressureBlock::is_definite() {
  if (_is_new) factorize();
  return _factors != nullptr;
}

void PressureBlock::factorize() {
  _is_new = false;
  if (!_spare) {
    _spare = std::make_unique<Factors>();
    _spare->analyzePattern(_block);
  }
  _spare->factorize(_block);
  if (_spare->info() == Eigen::Success) std::swap(_factors, _spare);
}

Eigen::VectorXd PressureBlock::solve(const Eigen::VectorXd& r_p) {
  if (!is_definite()) return Eigen::VectorXd::Zero(r_p.size());
  return _factors->solve(r_p);
}

Eigen::VectorXd PressureBlock::part(std::span<const double> unknowns) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(_unknowns.size()));
  for (std::size_t i = 0; i < _unknowns.size(); ++i)
    out[static_cast<Eigen::Index>(i)] = unknowns[_unknowns[i]];
  return out;
}

}  // namespace phynness
