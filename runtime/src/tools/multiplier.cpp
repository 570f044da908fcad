#include "tools/multiplier.hpp"

#include <cmath>

namespace PHN_RUNTIME {
namespace {

/// Smallest compliance of opposing displacements of two tools, as a fraction of each tool's own compliance. Below it
/// the tools are so close that opposing displacements are followed only in part (docs/decisions/coupled-tools.md).
constexpr double least_apart = 0.05;

}  // namespace

void Multipliers::find_stiffness() {
  const std::int32_t n = 3 * _c.n_tools;
  for (std::int32_t t = 0; t < _c.n_tools; ++t) {
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      const Matrix scaled = _c.point[t].root * rest_block(t, s) * _c.point[s].inverse_root;
      for (int k = 0; k < 9; ++k) _c.work[(3 * t + k / 3) * n + 3 * s + k % 3] = scaled.a[k];
    }
  }
  for (std::int32_t i = 0; i < n; ++i) {
    for (std::int32_t j = 0; j < i; ++j)
      _c.work[i * n + j] = _c.work[j * n + i] = (_c.work[i * n + j] + _c.work[j * n + i]) / 2;
  }
  diagonalize(_c.work, n, _c.vectors);
  double least = _c.work[0];
  for (std::int32_t e = 1; e < n; ++e) least = std::fmin(least, _c.work[e * n + e]);
  _apart = least >= least_apart;
  for (std::int32_t t = 0; t < _c.n_tools; ++t) {
    Constraint& point = _c.point[t];
    for (std::int32_t s = 0; s < _c.n_tools; ++s) {
      const Matrix scaled = inverse_block(t, s);
      _c.stiffness[at(t, s)] = point.root * scaled * _c.point[s].root;
      // Other tools can only stiffen a point.
      if (s == t) point.relative = point.inverse_root * inverse_of_stiffness(scaled, 1) * point.root;
    }
  }
}

Matrix Multipliers::inverse_block(std::int32_t t, std::int32_t s) const {
  const std::int32_t n = 3 * _c.n_tools;
  Matrix block = {};
  for (std::int32_t e = 0; e < n; ++e) {
    const double value = _c.work[e * n + e];
    const double inverse = value >= least_apart ? 1 / value : std::fmax(value, 0.0) / (least_apart * least_apart);
    for (int k = 0; k < 9; ++k)
      block.a[k] += _c.vectors[(3 * t + k / 3) * n + e] * inverse * _c.vectors[(3 * s + k % 3) * n + e];
  }
  return block;
}

void Multipliers::multiply(const Vector* moved, Vector* multiplier) const {
  for (std::int32_t j = 0; j < _c.n_tools; ++j) {
    multiplier[j] = {};
    for (std::int32_t s = 0; s < _c.n_tools; ++s) multiplier[j] += _c.stiffness[at(j, s)] * moved[s];
  }
}

bool Multipliers::correct() {
  if (!_apart) {
    multiply(_c.right, _c.forces);
    for (std::int32_t t = 0; t < _c.n_tools; ++t) _c.right[t] = _c.point[t].compliance * _c.forces[t];
    return true;
  }
  if (_c.n_tools == 1) return true;
  const std::int32_t n = 3 * _c.n_tools;
  double right[3 * most_coupled];
  for (std::int32_t i = 0; i < n; ++i) right[i] = _c.right[i / 3][i % 3];
  for (std::int32_t i = 0; i < n * n; ++i) _c.work[i] = _c.matrix[i];
  if (!solve_dense(_c.work, n, right)) return false;
  for (std::int32_t i = 0; i < n; ++i) _c.right[i / 3][i % 3] = right[i];
  return true;
}

}  // namespace PHN_RUNTIME
