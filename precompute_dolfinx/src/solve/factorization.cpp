#include "factorization.hpp"

#include <cmath>
#include <new>
#include <vector>

#include "petsc_check.hpp"

namespace phynness {

bool Factorization::factorize(Mat matrix) {
  _has_factors = false;
  try {
    PetscInt n = 0;
    const PetscInt *row_start = nullptr, *column = nullptr;
    PetscScalar* values = nullptr;
    PHYNNESS_PETSC(MatGetSize(matrix, &n, nullptr));
    PHYNNESS_PETSC(MatSeqAIJGetCSRAndMemType(matrix, &row_start, &column, &values, nullptr));
    if (!_factors)
      _factors.emplace(std::vector<std::int32_t>(row_start, row_start + n + 1),
                       std::vector<std::int32_t>(column, column + row_start[n]));
    _has_factors = _factors->factorize({values, static_cast<std::size_t>(row_start[n])});
  } catch (const std::bad_alloc&) {
    reset();
    throw failure("there is no memory for the factors of a tangent", "",
                  "give each rank more memory, or use fewer ranks on each machine");
  }
  return _has_factors;
}

bool Factorization::solve(Vec b, Vec x) {
  if (!_has_factors) return false;
  {
    const ReadValues from(b);
    const WriteValues to(x);
    const auto n = static_cast<std::size_t>(from.map().size());
    _factors->solve({from.map().data(), n}, {to.map().data(), n});
  }
  PetscReal size = 0;
  PHYNNESS_PETSC(VecNorm(x, NORM_1, &size));
  return std::isfinite(size);
}

int Factorization::negative_pivots() {
  if (!_has_factors) throw failure("pivots cannot be counted without factors", "", "please report this defect");
  return _factors->negative_pivots();
}

void Factorization::reset() {
  _factors.reset();
  _has_factors = false;
}

}  // namespace phynness
