#include "quasi_newton.hpp"

#include "petsc_check.hpp"

namespace phynness {

void QuasiNewton::clear() {
  _updates.clear();
  _y.resize(0);
}

void QuasiNewton::apply(Vec vector) const {
  const WriteValues values(vector);
  auto y = values.map();
  for (const auto& update : _updates) y += update.s.dot(y) * update.u;
}

void QuasiNewton::correct(Vec vector) {
  apply(vector);
  const WriteValues values(vector);
  auto y = values.map();
  if (_y.size() == y.size() && _length > 0) {
    const Eigen::VectorXd change = y - _y;  // H times the change of the residual
    const Eigen::VectorXd s = -_length * _y;
    const double denominator = s.dot(change);
    if (std::abs(denominator) > 1e-8 * s.squaredNorm()) {
      _updates.push_back({(s - change) / denominator, s});
      y += s.dot(y) * _updates.back().u;
    }
  }
}

void QuasiNewton::record_step(Vec vector, double length) {
  _y = ReadValues(vector).map();
  _length = length;
}

}  // namespace phynness
