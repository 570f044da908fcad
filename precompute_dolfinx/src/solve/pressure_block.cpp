#include "pressure_block.hpp"

#include <algorithm>

namespace phynness {

void PressureBlock::copy_from(Mat tangent) {
  if (empty()) return;
  if (_position.empty()) {
    const CsrPattern all(tangent);
    std::vector<std::int32_t> row_of(static_cast<std::size_t>(all.n), -1);
    for (std::size_t i = 0; i < _unknowns.size(); ++i) row_of[_unknowns[i]] = static_cast<std::int32_t>(i);
    std::vector<Eigen::Triplet<double, std::int32_t>> pattern;
    for (const auto i : _unknowns)
      for (auto k = all.row_start[i]; k < all.row_start[i + 1]; ++k)
        if (const auto j = row_of[all.column[k]]; j >= 0) pattern.emplace_back(row_of[i], j, k);
    const auto size = static_cast<Eigen::Index>(_unknowns.size());
    Eigen::SparseMatrix<double> position(size, size);  // positions are exactly representable as doubles
    position.setFromTriplets(pattern.begin(), pattern.end());
    _position.assign(position.valuePtr(), position.valuePtr() + position.nonZeros());
    _block = position;
  }
  const PetscScalar* values = nullptr;
  PHYNNESS_PETSC(MatSeqAIJGetArrayRead(tangent, &values));
  std::transform(_position.begin(), _position.end(), _block.valuePtr(), [&](auto k) { return -values[k]; });
  PHYNNESS_PETSC(MatSeqAIJRestoreArrayRead(tangent, &values));
  _is_unfactorized = true;
}

void PressureBlock::reset() {
  if (_factors) _reusable_factors = std::move(_factors);
  _is_unfactorized = false;
}

bool PressureBlock::is_definite() {
  if (_is_unfactorized) factorize();
  return _factors != nullptr;
}

void PressureBlock::factorize() {
  _is_unfactorized = false;
  if (!_reusable_factors) {
    _reusable_factors = std::make_unique<Factors>();
    _reusable_factors->analyzePattern(_block);
  }
  _reusable_factors->factorize(_block);
  if (_reusable_factors->info() == Eigen::Success) std::swap(_factors, _reusable_factors);
}

Eigen::VectorXd PressureBlock::solve(const Eigen::VectorXd& r_p) {
  if (!is_definite()) return Eigen::VectorXd::Zero(r_p.size());
  return _factors->solve(r_p);
}

Eigen::VectorXd PressureBlock::pressures_of(Vec unknowns) const { return ReadValues(unknowns).map()(_unknowns); }

}  // namespace phynness
