// Vectors, 3 x 3 matrices, and dense systems of a few unknowns. The order of all sums is fixed, so that results are
// bitwise the same on every machine.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/lookup.hpp"

namespace PHN_RUNTIME {

struct Vector {
  double x[3];

  double& operator[](int k) { return x[k]; }
  double operator[](int k) const { return x[k]; }
  Vector& operator+=(const Vector& b) {
    for (int k = 0; k < 3; ++k) x[k] += b.x[k];
    return *this;
  }
  Vector& operator-=(const Vector& b) {
    for (int k = 0; k < 3; ++k) x[k] -= b.x[k];
    return *this;
  }
  Vector& operator*=(double factor) {
    for (double& k : x) k *= factor;
    return *this;
  }
  Vector& operator/=(double divisor) {
    for (double& k : x) k /= divisor;
    return *this;
  }
};

inline Vector vector_at(const double* x) { return {{x[0], x[1], x[2]}}; }
inline Vector unit_vector(int axis, double size = 1) {
  return {{axis == 0 ? size : 0, axis == 1 ? size : 0, axis == 2 ? size : 0}};
}
inline Vector operator+(const Vector& a, const Vector& b) { return {{a[0] + b[0], a[1] + b[1], a[2] + b[2]}}; }
inline Vector operator-(const Vector& a, const Vector& b) { return {{a[0] - b[0], a[1] - b[1], a[2] - b[2]}}; }
inline Vector operator*(double factor, const Vector& a) { return {{a[0] * factor, a[1] * factor, a[2] * factor}}; }
inline Vector operator/(const Vector& a, double divisor) { return {{a[0] / divisor, a[1] / divisor, a[2] / divisor}}; }
inline double dot(const Vector& a, const Vector& b) { return dot(a.x, b.x); }
inline Vector cross(const Vector& a, const Vector& b) {
  return {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}};
}
inline double norm(const Vector& a) { return std::sqrt(dot(a, a)); }
/// Whether all components are finite.
inline bool is_finite(const Vector& a) { return 0 * a[0] + 0 * a[1] + 0 * a[2] == 0; }

/// A 3 x 3 matrix, row by row.
struct Matrix {
  double a[9];

  double& operator()(int i, int j) { return a[3 * i + j]; }
  double operator()(int i, int j) const { return a[3 * i + j]; }
  Matrix& operator+=(const Matrix& b) {
    for (int k = 0; k < 9; ++k) a[k] += b.a[k];
    return *this;
  }
  Matrix& operator-=(const Matrix& b) {
    for (int k = 0; k < 9; ++k) a[k] -= b.a[k];
    return *this;
  }
  Matrix& operator*=(double factor) {
    for (double& k : a) k *= factor;
    return *this;
  }
};

inline Matrix diagonal(double value) { return {{value, 0, 0, 0, value, 0, 0, 0, value}}; }
inline Matrix operator+(Matrix a, const Matrix& b) { return a += b; }
inline Matrix operator-(Matrix a, const Matrix& b) { return a -= b; }
inline Matrix operator*(double factor, Matrix a) { return a *= factor; }
inline Vector operator*(const Matrix& m, const Vector& x) {
  Vector y;
  for (int i = 0; i < 3; ++i) y[i] = m(i, 0) * x[0] + m(i, 1) * x[1] + m(i, 2) * x[2];
  return y;
}
inline Vector transposed_times(const Matrix& m, const Vector& x) {
  Vector y;
  for (int i = 0; i < 3; ++i) y[i] = m(0, i) * x[0] + m(1, i) * x[1] + m(2, i) * x[2];
  return y;
}
inline Matrix operator*(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return c;
}
/// a b^T
inline Matrix outer(const Vector& a, const Vector& b) {
  Matrix c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a[i] * b[j];
  return c;
}
inline Matrix symmetric_part(const Matrix& m) {
  Matrix s;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s(i, j) = (m(i, j) + m(j, i)) / 2;
  return s;
}
/// Sum of products of corresponding entries.
inline double inner_product(const Matrix& a, const Matrix& b) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += a.a[k] * b.a[k];
  return sum;
}

/// Inverse of a matrix, which is made slightly stiffer first where it is nearly singular.
inline Matrix inverse_of(const Matrix& matrix) {
  Matrix a = matrix, inverse;
  double size = 0;
  for (const double k : a.a) size = std::fmax(size, std::fabs(k));
  for (double shift = 1e-3;; shift *= 10) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
        inverse(j, i) = a(p, r) * a(q, s) - a(p, s) * a(q, r);
      }
    const double determinant = a(0, 0) * inverse(0, 0) + a(0, 1) * inverse(1, 0) + a(0, 2) * inverse(2, 0);
    if (std::fabs(determinant) > 1e-9 * size * size * size || !(size > 0) || shift > 1e3)
      return (determinant != 0 ? 1 / determinant : 0) * inverse;
    for (int i = 0; i < 3; ++i) a(i, i) = matrix(i, i) + shift * size;
  }
}

/// A small dense matrix in memory of another object, row by row.
template <class T>
struct MatrixView {
  T* data;
  std::int32_t n_columns;

  T& operator()(std::int32_t row, std::int32_t column) const { return data[row * n_columns + column]; }
};

/// Values with three indices, of which the last varies fastest, in memory of another object.
template <class T>
struct ArrayView {
  T* data;
  std::int32_t n_second, n_third;

  T& operator()(std::int32_t first, std::int32_t second, std::int32_t third) const {
    return data[(first * n_second + second) * n_third + third];
  }
};

/// Arrays of `length` numbers with three indices.
struct ArraysView {
  double* data;
  std::int32_t n_second, n_third;
  std::size_t length;

  double* operator()(std::int32_t first, std::int32_t second, std::int32_t third) const {
    return data + static_cast<std::size_t>((first * n_second + second) * n_third + third) * length;
  }
};

/// y += factor x. @param n  length of both
inline void add_scaled(double factor, const double* x, std::int32_t n, double* y) {
  for (std::int32_t i = 0; i < n; ++i) y[i] += factor * x[i];
}

inline void set_zero(double* x, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) x[i] = 0;
}

/// Whether all n numbers are finite.
inline bool all_finite(const double* x, std::size_t n) {
  double sum = 0;  // 0 times infinity or NaN is NaN
  for (std::size_t i = 0; i < n; ++i) sum += 0 * x[i];
  return sum == 0;
}

/// One Jacobi rotation of rows and columns p and q, after which a_pq is 0.
inline void rotate_pair(const MatrixView<double>& a, std::int32_t p, std::int32_t q,
                        const MatrixView<double>& vectors) {
  const std::int32_t n = a.n_columns;
  const double off = a(p, q);
  const double half = (a(q, q) - a(p, p)) / (2 * off);
  const double tangent = (half < 0 ? -1 : 1) / (std::fabs(half) + std::sqrt(half * half + 1));
  const double cosine = 1 / std::sqrt(tangent * tangent + 1), sine = tangent * cosine;
  for (std::int32_t k = 0; k < n; ++k) {
    const double x = a(k, p), y = a(k, q);
    a(k, p) = cosine * x - sine * y;
    a(k, q) = sine * x + cosine * y;
  }
  for (std::int32_t k = 0; k < n; ++k) {
    const double x = a(p, k), y = a(q, k);
    a(p, k) = cosine * x - sine * y;
    a(q, k) = sine * x + cosine * y;
    const double v = vectors(k, p), w = vectors(k, q);
    vectors(k, p) = cosine * v - sine * w;
    vectors(k, q) = sine * v + cosine * w;
  }
}

/// Eigenvalues of a symmetric n x n matrix, which replace its diagonal, and eigenvectors in columns. Method: cyclic
/// Jacobi rotations until the off-diagonal entries are rounding errors, at most ten sweeps (a 3 x 3 matrix takes six, a
/// 24 x 24 matrix eight).
inline void diagonalize(double* a, std::int32_t n, double* vectors) {
  for (std::int32_t i = 0; i < n * n; ++i) vectors[i] = i % (n + 1) == 0 ? 1 : 0;
  for (int sweep = 0; sweep < 10; ++sweep) {
    double off_diagonal = 0, size = 0;
    for (std::int32_t i = 0; i < n * n; ++i) {
      const double square = a[i] * a[i];
      size += square;
      if (i % (n + 1) != 0) off_diagonal += square;
    }
    if (!(off_diagonal > 1e-34 * size)) return;
    for (std::int32_t p = 0; p < n - 1; ++p)
      for (std::int32_t q = p + 1; q < n; ++q)
        if (a[p * n + q] != 0) rotate_pair({a, n}, p, q, {vectors, n});
  }
}

/// Inverse of a symmetric matrix whose eigenvalues below `least` are replaced by `least`.
inline Matrix inverse_of_stiffness(const Matrix& stiffness, double least) {
  Matrix a = stiffness, v, inverse = {};
  diagonalize(a.a, 3, v.a);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) inverse(i, j) += v(i, k) * v(j, k) / std::fmax(a(k, k), least);
  return inverse;
}

/// Gaussian elimination with partial pivoting. The solution replaces the right-hand side.
/// @param a  n x n, destroyed. @return false if a is singular
inline bool solve_dense(const MatrixView<double>& a, double* right) {
  const std::int32_t n = a.n_columns;
  double size = 0;
  for (std::int32_t i = 0; i < n * n; ++i) size = std::fmax(size, std::fabs(a.data[i]));
  for (std::int32_t k = 0; k < n; ++k) {
    std::int32_t pivot = k;
    for (std::int32_t i = k + 1; i < n; ++i)
      if (std::fabs(a(i, k)) > std::fabs(a(pivot, k))) pivot = i;
    if (!(std::fabs(a(pivot, k)) > 1e-13 * size)) return false;
    for (std::int32_t j = 0; j <= n && pivot != k; ++j) {
      double &one = j < n ? a(k, j) : right[k], &other = j < n ? a(pivot, j) : right[pivot];
      const double swapped = one;
      one = other;
      other = swapped;
    }
    for (std::int32_t i = k + 1; i < n; ++i) {
      const double factor = a(i, k) / a(k, k);
      add_scaled(-factor, &a(k, k), n - k, &a(i, k));
      right[i] -= factor * right[k];
    }
  }
  for (std::int32_t k = n - 1; k >= 0; --k) {
    for (std::int32_t i = k + 1; i < n; ++i) right[k] -= a(k, i) * right[i];
    right[k] /= a(k, k);
  }
  return true;
}

}  // namespace PHN_RUNTIME
