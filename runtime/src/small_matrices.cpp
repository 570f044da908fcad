#include "small_matrices.hpp"

#include <cmath>

namespace PHN_RUNTIME {

void multiply_matrices(const double* a, const double* b, double* c) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
  }
}

void add_scaled(double factor, const double* x, std::int32_t n, double* y) {
  for (std::int32_t i = 0; i < n; ++i) y[i] += factor * x[i];
}

void set_zero(double* x, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) x[i] = 0;
}

bool all_finite(const double* x, std::size_t n) {
  double sum = 0;  // 0 times infinity is no number either
  for (std::size_t i = 0; i < n; ++i) sum += 0 * x[i];
  return sum == 0;
}

void invert(const double* given, double* inverse) {
  double a[9], size = 0;
  for (int i = 0; i < 9; ++i) {
    a[i] = given[i];
    size = std::fmax(size, std::fabs(a[i]));
  }
  for (double shift = 1e-3;; shift *= 10) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, s = (j + 2) % 3;
        inverse[3 * j + i] = a[3 * p + r] * a[3 * q + s] - a[3 * p + s] * a[3 * q + r];
      }
    }
    const double determinant = a[0] * inverse[0] + a[1] * inverse[3] + a[2] * inverse[6];
    if (std::fabs(determinant) > 1e-9 * size * size * size || !(size > 0) || shift > 1e3) {
      const double factor = determinant != 0 ? 1 / determinant : 0;
      for (int i = 0; i < 9; ++i) inverse[i] *= factor;
      return;
    }
    for (int i = 0; i < 3; ++i) a[4 * i] = given[4 * i] + shift * size;
  }
}

bool solve_dense(double* a, std::int32_t n, double* right) {
  double size = 0;
  for (std::int32_t i = 0; i < n * n; ++i) size = std::fmax(size, std::fabs(a[i]));
  for (std::int32_t k = 0; k < n; ++k) {
    std::int32_t pivot = k;
    for (std::int32_t i = k + 1; i < n; ++i) {
      if (std::fabs(a[i * n + k]) > std::fabs(a[pivot * n + k])) pivot = i;
    }
    if (!(std::fabs(a[pivot * n + k]) > 1e-13 * size)) return false;
    for (std::int32_t j = 0; j <= n && pivot != k; ++j) {
      double &one = j < n ? a[k * n + j] : right[k], &other = j < n ? a[pivot * n + j] : right[pivot];
      const double kept = one;
      one = other;
      other = kept;
    }
    for (std::int32_t i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] / a[k * n + k];
      add_scaled(-factor, a + k * n + k, n - k, a + i * n + k);
      right[i] -= factor * right[k];
    }
  }
  for (std::int32_t k = n - 1; k >= 0; --k) {
    for (std::int32_t i = k + 1; i < n; ++i) right[k] -= a[k * n + i] * right[i];
    right[k] /= a[k * n + k];
  }
  return true;
}

void diagonalize(double* a, std::int32_t n, double* vectors) {
  for (std::int32_t i = 0; i < n * n; ++i) vectors[i] = i % (n + 1) == 0 ? 1 : 0;
  for (int sweep = 0; sweep < 10; ++sweep) {
    double off_diagonal = 0, size = 0;
    for (std::int32_t i = 0; i < n * n; ++i) {
      const double square = a[i] * a[i];
      size += square;
      if (i % (n + 1) != 0) off_diagonal += square;
    }
    if (!(off_diagonal > 1e-34 * size)) return;
    for (std::int32_t p = 0; p < n - 1; ++p) {
      for (std::int32_t q = p + 1; q < n; ++q) {
        const double off = a[p * n + q];
        if (off == 0) continue;
        const double half = (a[q * n + q] - a[p * n + p]) / (2 * off);
        const double tangent = (half < 0 ? -1 : 1) / (std::fabs(half) + std::sqrt(half * half + 1));
        const double cosine = 1 / std::sqrt(tangent * tangent + 1), sine = tangent * cosine;
        for (std::int32_t k = 0; k < n; ++k) {
          const double x = a[k * n + p], y = a[k * n + q];
          a[k * n + p] = cosine * x - sine * y;
          a[k * n + q] = sine * x + cosine * y;
        }
        for (std::int32_t k = 0; k < n; ++k) {
          const double x = a[p * n + k], y = a[q * n + k];
          a[p * n + k] = cosine * x - sine * y;
          a[q * n + k] = sine * x + cosine * y;
          const double v = vectors[k * n + p], w = vectors[k * n + q];
          vectors[k * n + p] = cosine * v - sine * w;
          vectors[k * n + q] = sine * v + cosine * w;
        }
      }
    }
  }
}

void invert_stiffness(const double* stiffness, double least, double* inverse) {
  double a[9], v[9];
  for (int i = 0; i < 9; ++i) a[i] = stiffness[i];
  diagonalize(a, 3, v);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      inverse[3 * i + j] = 0;
      for (int k = 0; k < 3; ++k) inverse[3 * i + j] += v[3 * i + k] * v[3 * j + k] / std::fmax(a[4 * k], least);
    }
  }
}

}  // namespace PHN_RUNTIME
