#include "quasi_newton.hpp"

#include "petsc_check.hpp"

namespace phynness {

void QuasiNewton::clear() {
  _updates.clear();
  _y.resize(0);
}

void QuasiNewton::apply(Vec vector) const {
  PetscInt n = 0;
  PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetLocalSize(vector, &n));
  PHYNNESS_PETSC(VecGetArray(vector, &values));
  Eigen::Map<Eigen::VectorXd> y(values, n);
  for (const auto& update : _updates) y += update.s.dot(y) * update.u;
  PHYNNESS_PETSC(VecRestoreArray(vector, &values));
}

void QuasiNewton::correct(Vec vector) {
  PetscInt n = 0;
  PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetLocalSize(vector, &n));
  PHYNNESS_PETSC(VecGetArray(vector, &values));
  Eigen::Map<Eigen::VectorXd> y(values, n);
  for (const auto& update : _updates) y += update.s.dot(y) * update.u;
  if (_y.size() == n && _length > 0) {
    const Eigen::VectorXd change = y - _y;  // H times the change of the residual
    const Eigen::VectorXd s = -_length * _y;
    const double denominator = s.dot(change);
    if (std::abs(denominator) > 1e-8 * s.squaredNorm()) {
      _updates.push_back({(s - change) / denominator, s});
      y += s.dot(y) * _updates.back().u;
    }
  }
  PHYNNESS_PETSC(VecRestoreArray(vector, &values));
}

void QuasiNewton::remember(Vec vector, double length) {
  PetscInt n = 0;
  const PetscScalar* values = nullptr;
  PHYNNESS_PETSC(VecGetLocalSize(vector, &n));
  PHYNNESS_PETSC(VecGetArrayRead(vector, &values));
  _y = Eigen::Map<const Eigen::VectorXd>(values, n);
  _length = length;
  PHYNNESS_PETSC(VecRestoreArrayRead(vector, &values));
}

}  // namespace phynness
