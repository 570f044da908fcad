// Compliance of the tools on a reduced body.
#pragma once

#include <cstring>

#include "body/body.hpp"

namespace PHN_RUNTIME {

inline constexpr std::int32_t most_body_tools = PHN_MOST_COUPLED;

/// Part of a compliance below which a pivot is the rounding of the factor, which has floats.
inline constexpr double rounded_away = 1e-7;

inline double product(const double* a, const double* b, std::int32_t n) {
  double sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// sum_k springs[r][k] x[k]: by how much the springs of near tools are stretched by forces x [m].
inline double stretched(const phn_body_state& state, std::int32_t r, const double* x) {
  return state.has_springs ? product(state.springs[r], x, state.n_rows) : 0;
}

/// Compliance of the tools: C = rows K^-1 rows^T with their springs S, factorized as L L^T. The factor of K has the
/// multiples H of the squares of the displacements under the tools, so that C + S + S H S takes the place of C + S, and
/// the forces x of a solution belong to the forces x - H (d - S x) of the tools, d: what the tools are ahead.
struct Compliance {
  double lower[3 * most_body_tools][3 * most_body_tools];

  /// Of n rows from `first` on. @param factor  of K. state.moved receives K^-1 rows^T
  void set(const phn_body_state& state, const float* factor, std::int32_t first, std::int32_t n) {
    solve_rows(state, factor, first, n);
    take(state, first, n, factor == state.factor);
  }
  static void solve_rows(const phn_body_state& state, const float* factor, std::int32_t first, std::int32_t n) {
    const std::int32_t stride = state.body->stride;
    for (std::int32_t r = first; r < first + n; ++r) {
      const std::int64_t at = static_cast<std::int64_t>(r) * stride;
      memcpy(state.moved + at, state.rows + at, static_cast<std::size_t>(stride) * sizeof(double));
      state.kernels->solve(factor, state.body->info.n_modes, stride, state.moved + at);
    }
  }
  void set(const phn_body_state& state, const float* factor) { set(state, factor, 0, state.n_rows); }

  /// Of n rows from `first` on, with state.moved of a call of set().
  void take(const phn_body_state& state, std::int32_t first, std::int32_t n, bool is_held) {
    const auto at = [&](const double* of, std::int32_t r) {
      return of + static_cast<std::int64_t>(first + r) * state.body->stride;
    };
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k)
        lower[r][k] = product(at(state.rows, r), at(state.moved, k), state.body->info.n_modes);
    if (state.has_springs && n >= state.n_rows) add_springs(state, n, is_held);
    factorize(n);
  }

  /// L in place of L L^T. @return whether that is definite
  bool factorize(std::int32_t n) {
    bool is_definite = true;
    for (std::int32_t r = 0; r < n; ++r) {
      for (std::int32_t k = 0; k < r; ++k) lower[r][k] = (lower[r][k] - product(lower[r], lower[k], k)) / lower[k][k];
      const double pivot = lower[r][r] - product(lower[r], lower[r], r);
      const double least = rounded_away * lower[r][r];
      lower[r][r] = least > 0 ? std::sqrt(std::fmax(pivot, least)) : HUGE_VAL;
      is_definite = is_definite && pivot > least && least > 0;
    }
    return is_definite;
  }

  /// Compliance of a tool alone at rest [m/N]. @param first  of its three rows
  static void alone(const phn_body_state& state, std::int32_t first, double own[3][3]) {
    solve_rows(state, state.factor_at_rest, first, 3);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        own[i][k] = product(state.rows + static_cast<std::int64_t>(first + (i > k ? i : k)) * state.body->stride,
                            state.moved + static_cast<std::int64_t>(first + (i > k ? k : i)) * state.body->stride,
                            state.body->info.n_modes);
  }

  void add_springs(const phn_body_state& state, std::int32_t n, bool is_held) {
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k) {
        lower[r][k] += state.springs[r][k];
        for (std::int32_t i = 0; i < state.n_rows && is_held; ++i)
          lower[r][k] += state.springs[r][i] * state.held[i] * state.springs[i][k];
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
