// Numbers, numbers with derivatives, and tensors of both. laws/tables/tables.py makes formulas of the law files, for
// the energy and its first derivative. With numbers with derivatives the formulas give the second derivatives, too.
#pragma once

#include "core/bound.hpp"

namespace PHN_RUNTIME {

/// Natural logarithm to rounding, exactly 0 at 1. Numbers that are not finite, normal and > 0 give NaN.
inline double ln(double x) {
  if (!(x >= 2.3e-308 && x - x == 0)) return (x - x) / (x - x);
  int exponent = 0;
  double m = mantissa(x, exponent);
  if (m < 0.7) {
    m *= 2;
    --exponent;
  }
  const double z = (m - 1) / (m + 1), z2 = z * z;
  double sum = 0;  // atanh(z) / z, |z| <= 3/17
  for (int k = 21; k >= 1; k -= 2) sum = sum * z2 + 1 / static_cast<double>(k);
  return exponent * 0.69314718055994530942 + 2 * z * sum;
}
/// Exponential function, clamped to 2^-430 ... 2^430.
inline double exp(double x) {
  const double power = log2_e * x;
  return power < 0 ? power_of_half(-power) : 1 / power_of_half(power);
}
inline double sinh(double x) {
  if (!(x * x < 1)) return (exp(x) - exp(-x)) / 2;
  double sum = 1;
  for (int k = 18; k >= 2; k -= 2) sum = 1 + sum * x * x / (k * (k + 1));
  return x * sum;
}
inline double sqrt(double x) { return square_root(x); }

/// A number and its derivatives with respect to the nine components of F.
struct Dual {
  double value;
  double slope[9];
};

/// f(x) with the given value and derivative.
inline Dual chain(const Dual& x, double value, double derivative) {
  Dual y;
  y.value = value;
  for (int k = 0; k < 9; ++k) y.slope[k] = derivative * x.slope[k];
  return y;
}
inline Dual operator+(const Dual& a, const Dual& b) {
  Dual c;
  c.value = a.value + b.value;
  for (int k = 0; k < 9; ++k) c.slope[k] = a.slope[k] + b.slope[k];
  return c;
}
inline Dual operator-(const Dual& a, const Dual& b) {
  Dual c;
  c.value = a.value - b.value;
  for (int k = 0; k < 9; ++k) c.slope[k] = a.slope[k] - b.slope[k];
  return c;
}
inline Dual operator*(const Dual& a, const Dual& b) {
  Dual c;
  c.value = a.value * b.value;
  for (int k = 0; k < 9; ++k) c.slope[k] = a.value * b.slope[k] + a.slope[k] * b.value;
  return c;
}
inline Dual operator+(const Dual& a, double b) {
  Dual c = a;
  c.value += b;
  return c;
}
inline Dual operator*(const Dual& a, double b) { return chain(a, a.value * b, b); }
inline Dual operator/(double a, const Dual& b) { return chain(b, a / b.value, -a / (b.value * b.value)); }
inline Dual operator-(const Dual& a) { return a * -1.0; }
inline Dual operator+(double a, const Dual& b) { return b + a; }
inline Dual operator-(const Dual& a, double b) { return a + -b; }
inline Dual operator-(double a, const Dual& b) { return -b + a; }
inline Dual operator*(double a, const Dual& b) { return b * a; }
inline Dual operator/(const Dual& a, double b) { return chain(a, a.value / b, 1 / b); }
inline Dual operator/(const Dual& a, const Dual& b) { return a * (1.0 / b); }

inline Dual exp(const Dual& x) {
  const double value = exp(x.value);
  return chain(x, value, value);
}
inline Dual ln(const Dual& x) { return chain(x, ln(x.value), 1 / x.value); }
inline Dual sinh(const Dual& x) { return chain(x, sinh(x.value), (exp(x.value) + exp(-x.value)) / 2); }
inline Dual sqrt(const Dual& x) {
  const double value = sqrt(x.value);
  return chain(x, value, 0.5 / value);
}
template <int n, class T>
T power(const T& x) {
  T result = x;
  for (int i = 1; i < n; ++i) result = result * x;
  return result;
}

/// A 3 x 3 tensor, row by row.
template <class T>
struct Tensor {
  T a[9];
};

template <class T>
Tensor<T> operator+(const Tensor<T>& a, const Tensor<T>& b) {
  Tensor<T> c;
  for (int i = 0; i < 9; ++i) c.a[i] = a.a[i] + b.a[i];
  return c;
}
template <class T>
Tensor<T> operator-(const Tensor<T>& a, const Tensor<T>& b) {
  Tensor<T> c;
  for (int i = 0; i < 9; ++i) c.a[i] = a.a[i] - b.a[i];
  return c;
}
/// @param b  a number with or without derivatives
template <class T, class B>
Tensor<T> operator*(const Tensor<T>& a, const B& b) {
  Tensor<T> c;
  for (int i = 0; i < 9; ++i) c.a[i] = a.a[i] * b;
  return c;
}
template <class T, class B>
Tensor<T> operator*(const B& a, const Tensor<T>& b) {
  return b * a;
}
template <class T>
Tensor<T> operator-(const Tensor<T>& a) {
  return a * -1.0;
}
template <class T, class B>
Tensor<T> operator/(const Tensor<T>& a, const B& b) {
  return a * (1.0 / b);
}
template <class T>
Tensor<T> operator*(const Tensor<T>& a, const Tensor<T>& b) {
  Tensor<T> c;
  for (int i = 0; i < 9; ++i) {
    const T *row = a.a + i / 3 * 3, *column = b.a + i % 3;
    c.a[i] = row[0] * column[0] + row[1] * column[3] + row[2] * column[6];
  }
  return c;
}
template <class T>
Tensor<T> transpose(const Tensor<T>& a) {
  return {{a.a[0], a.a[3], a.a[6], a.a[1], a.a[4], a.a[7], a.a[2], a.a[5], a.a[8]}};
}
template <class T>
Tensor<T> sym(const Tensor<T>& a) {
  return (a + transpose(a)) / 2.0;
}
template <class T>
Tensor<T> identity(const Tensor<T>&) {
  Tensor<T> unit{};
  for (int i = 0; i < 9; i += 4) unit.a[i] = unit.a[i] + 1.0;
  return unit;
}
template <class T>
T tr(const Tensor<T>& a) {
  return a.a[0] + a.a[4] + a.a[8];
}
template <class T>
T inner(const Tensor<T>& a, const Tensor<T>& b) {
  T sum = a.a[0] * b.a[0];
  for (int i = 1; i < 9; ++i) sum = sum + a.a[i] * b.a[i];
  return sum;
}
template <class T>
T det(const Tensor<T>& t) {
  const T* a = t.a;
  return a[0] * (a[4] * a[8] - a[5] * a[7]) + a[1] * (a[5] * a[6] - a[3] * a[8]) + a[2] * (a[3] * a[7] - a[4] * a[6]);
}
/// The derivative of the determinant.
template <class T>
Tensor<T> cofactors(const Tensor<T>& t) {
  Tensor<T> c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const T *below = t.a + (i + 1) % 3 * 3, *above = t.a + (i + 2) % 3 * 3;
      const int right = (j + 1) % 3, left = (j + 2) % 3;
      c.a[3 * i + j] = below[right] * above[left] - below[left] * above[right];
    }
  return c;
}

template <class T>
using Formula = T (*)(const Tensor<T>& F, const double* parameters, Tensor<T>& first);

/// BodyEnergy of a formula. @tparam inside  positive where the law is defined
template <Formula<double> once, Formula<Dual> twice, double (*inside)(const Tensor<double>&, const double*)>
bool derivatives(const double* F, const double* parameters, double& value, double* first, double* second) {
  Tensor<double> plain, slopes;
  for (int k = 0; k < 9; ++k) plain.a[k] = F[k];
  if (!(inside(plain, parameters) > 0)) return false;
  double zero = 0;
  if (second) {
    Tensor<Dual> variables, dual_slopes;
    for (int k = 0; k < 9; ++k) {
      variables.a[k] = {F[k], {}};
      variables.a[k].slope[k] = 1;
    }
    value = twice(variables, parameters, dual_slopes).value;
    for (int k = 0; k < 9; ++k) {
      slopes.a[k] = dual_slopes.a[k].value;
      for (int l = 0; l < 9; ++l) zero += 0 * (second[9 * k + l] = dual_slopes.a[k].slope[l]);
    }
  } else {
    value = once(plain, parameters, slopes);
  }
  for (int k = 0; k < 9; ++k) zero += 0 * (first[k] = slopes.a[k]);
  return zero + 0 * value == 0;
}

}  // namespace PHN_RUNTIME
