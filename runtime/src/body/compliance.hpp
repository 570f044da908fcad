// Compliance of the tools on a reduced body.
#pragma once

#include <cstring>

#include "body/body.hpp"

namespace PHN_RUNTIME {

inline constexpr std::int32_t most_body_tools = PHN_MOST_COUPLED;

/// A pivot below this part of the diagonal is the rounding error of the stiffness's factor, which consists of floats.
inline constexpr double pivot_tolerance = 1e-7;

inline double product(const double* a, const double* b, std::int32_t n) {
  double sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

/// Component r of S x: the extension of the springs by forces x [m].
inline double spring_extension(const phn_body_state& state, std::int32_t r, const double* x) {
  return state.has_springs ? product(state.spring_compliance[r], x, state.n_constraints) : 0;
}

/// The compliance C + S of the constraints in the form L L^T, where C is R K^-1 R^T. The factor is that of K + R^T H R,
/// with which C + S + S H S takes the place of C + S. Of a solution x the forces at the tools are then x - H (r - S x),
/// where r is the residual d - R q.
struct Compliance {
  double lower[3 * most_body_tools][3 * most_body_tools];

  /// Sets the compliance of all tools that are held, and state.compliance_rows.
  void set(const phn_body_state& state, const float* factor) {
    solve_rows(state, factor, 0, state.n_constraints);
    assemble(state, state.n_constraints, factor == state.factor);
  }
  /// Applies the inverse of the stiffness to n rows from `first` on.
  static void solve_rows(const phn_body_state& state, const float* factor, std::int32_t first, std::int32_t n) {
    const std::int32_t stride = state.body->stride;
    for (std::int32_t r = first; r < first + n; ++r) {
      memcpy(state.compliance_row(r), state.constraint_row(r), static_cast<std::size_t>(stride) * sizeof(double));
      state.kernels->solve(factor, state.body->info.n_modes, stride, state.compliance_row(r));
    }
  }
  /// Sets the compliance of the first n rows from state.compliance_rows.
  /// @param has_penalty  whether the factor was that of K + R^T H R
  void assemble(const phn_body_state& state, std::int32_t n, bool has_penalty) {
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k)
        lower[r][k] = product(state.constraint_row(r), state.compliance_row(k), state.body->info.n_modes);
    if (state.has_springs) add_springs(state, n, has_penalty);
    factorize(n);
  }

  /// Replaces the matrix by its factor L. @return whether it is definite
  bool factorize(std::int32_t n) {
    bool is_definite = true;
    for (std::int32_t r = 0; r < n; ++r) {
      for (std::int32_t k = 0; k < r; ++k) lower[r][k] = (lower[r][k] - product(lower[r], lower[k], k)) / lower[k][k];
      const double pivot = lower[r][r] - product(lower[r], lower[r], r);
      const double smallest = pivot_tolerance * lower[r][r];
      lower[r][r] = smallest > 0 ? std::sqrt(std::fmax(pivot, smallest)) : HUGE_VAL;
      is_definite = is_definite && pivot > smallest && smallest > 0;
    }
    return is_definite;
  }

  /// Compliance at rest of a single tool [m/N]. @param first  of its three rows
  static void of_single_tool(const phn_body_state& state, std::int32_t first, double compliance[3][3]) {
    solve_rows(state, state.factor_at_rest, first, 3);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        compliance[i][k] = product(state.constraint_row(first + (i > k ? i : k)),
                                   state.compliance_row(first + (i > k ? k : i)), state.body->info.n_modes);
  }

  void add_springs(const phn_body_state& state, std::int32_t n, bool has_penalty) {
    for (std::int32_t r = 0; r < n; ++r)
      for (std::int32_t k = 0; k <= r; ++k) {
        lower[r][k] += state.spring_compliance[r][k];
        for (std::int32_t i = 0; i < state.n_constraints && has_penalty; ++i)
          lower[r][k] += state.spring_compliance[r][i] * state.penalty[i] * state.spring_compliance[i][k];
      }
  }

  /// Replaces the displacements x of n rows by the forces that cause them.
  void solve(std::int32_t n, double* x) const {
    for (std::int32_t r = 0; r < n; ++r) x[r] = (x[r] - product(lower[r], x, r)) / lower[r][r];
    for (std::int32_t r = n - 1; r >= 0; --r) {
      for (std::int32_t k = r + 1; k < n; ++k) x[r] -= lower[k][r] * x[k];
      x[r] /= lower[r][r];
    }
  }
};

}  // namespace PHN_RUNTIME
