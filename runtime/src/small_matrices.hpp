// Matrices of 3 x 3, row by row, and dense systems of a few unknowns.
#pragma once

#include <cstddef>
#include <cstdint>

#include "strict_arithmetic.hpp"

namespace PHN_RUNTIME {

/// y = a x
inline void multiply(const double* a, const double* x, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = a[3 * i] * x[0] + a[3 * i + 1] * x[1] + a[3 * i + 2] * x[2];
}

/// y = a^T x
inline void multiply_transposed(const double* a, const double* x, double* y) {
  for (int i = 0; i < 3; ++i) y[i] = a[i] * x[0] + a[3 + i] * x[1] + a[6 + i] * x[2];
}

/// c = a b. @param c  none of the two
void multiply_matrices(const double* a, const double* b, double* c);

/// y += factor x. @param n  of both
void add_scaled(double factor, const double* x, std::int32_t n, double* y);

void set_zero(double* x, std::size_t n);

/// Whether none is infinite or not a number.
bool all_finite(const double* x, std::size_t n);

/// Sum of products of the entries.
inline double inner_product(const double* a, const double* b) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += a[k] * b[k];
  return sum;
}

/// Inverse of a 3 x 3 matrix, of one a little stiffer if it is close to singular.
void invert(const double* given, double* inverse);

/// Eigenvalues of a symmetric n x n matrix, which is replaced by them on its diagonal, and eigenvectors in columns: cyclic
/// Jacobi rotations, until what is off the diagonal is rounding, ten sweeps at most (3 x 3: six, 24 x 24: eight).
void diagonalize(double* a, std::int32_t n, double* vectors);

/// Inverse of a symmetric 3 x 3 matrix whose eigenvalues count as `least` at least.
void invert_stiffness(const double* stiffness, double least, double* inverse);

/// Gaussian elimination with partial pivoting; the solution replaces the right-hand side.
/// @param a  n x n, destroyed. @return false if a is singular
bool solve_dense(double* a, std::int32_t n, double* right);

}  // namespace PHN_RUNTIME
