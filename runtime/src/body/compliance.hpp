// Compliance of the tools on a reduced body.
#pragma once

#include <cstring>

#include "body/body.hpp"

namespace PHN_RUNTIME {

inline constexpr std::int32_t most_body_tools = PHN_MOST_COUPLED;

/// Part of a tool's compliance that the tools before it leave; at 0.2 radii it is 7e-4 and more.
inline constexpr double nearly_one = 1e-4;

inline double product(const double* a, const double* b, std::int32_t n) {
  double sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Compliance of the tools: rows K^-1 rows^T, factorized as L L^T.
struct Compliance {
  double lower[3 * most_body_tools][3 * most_body_tools];

  /// Of n rows from `first` on. @param factor  of K. state.moved receives K^-1 rows^T
  void set(const phn_body_state& state, const float* factor, std::int32_t first, std::int32_t n) {
    const std::int32_t stride = state.body->stride;
    for (std::int32_t r = first; r < first + n; ++r) {
      const std::int64_t at = static_cast<std::int64_t>(r) * stride;
      memcpy(state.moved + at, state.rows + at, static_cast<std::size_t>(stride) * sizeof(double));
      state.kernels->solve(factor, state.body->info.n_modes, stride, state.moved + at);
    }
    take(state, first, n);
  }
  void set(const phn_body_state& state, const float* factor) { set(state, factor, 0, state.n_rows); }

  /// Of n rows from `first` on, with state.moved of a call of set().
  void take(const phn_body_state& state, std::int32_t first, std::int32_t n) {
    const auto at = [&](const double* of, std::int32_t r) {
      return of + static_cast<std::int64_t>(first + r) * state.body->stride;
    };
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k)
        lower[r][k] = product(at(state.rows, r), at(state.moved, k), state.body->info.n_modes);
    for (std::int32_t r = 0; r < n; ++r) {
      for (std::int32_t k = 0; k < r; ++k) lower[r][k] = (lower[r][k] - product(lower[r], lower[k], k)) / lower[k][k];
      const double pivot = lower[r][r] - product(lower[r], lower[r], r);
      // Of tools at nearly one place the later ones follow only in part, as if held by a spring of this compliance.
      const double least = nearly_one * lower[r][r];
      lower[r][r] = least > 0 ? std::sqrt(std::fmax(pivot, least)) : HUGE_VAL;
    }
  }

  /// The forces that move n rows by x, in place of x.
  void solve(std::int32_t n, double* x) const {
    for (std::int32_t r = 0; r < n; ++r) x[r] = (x[r] - product(lower[r], x, r)) / lower[r][r];
    for (std::int32_t r = n - 1; r >= 0; --r) {
      for (std::int32_t k = r + 1; k < n; ++k) x[r] -= lower[k][r] * x[k];
      x[r] /= lower[r][r];
    }
  }
};

}  // namespace PHN_RUNTIME
