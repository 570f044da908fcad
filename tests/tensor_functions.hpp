// Functions in which the energies of law files are written, for real and complex numbers; used by the generated file
// declared_laws.cpp.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <complex>

namespace phynness::test {

template <class T>
using Tensor = Eigen::Matrix<T, 3, 3>;

template <class A>
using Matrix = Eigen::MatrixBase<A>;

// Without conjugation: an energy of complex F is to be analytic (first_piola of closed_forms.hpp).
template <class A, class B>
typename A::Scalar inner(const Matrix<A>& a, const Matrix<B>& b) {
  return a.cwiseProduct(b).sum();
}
template <class A>
typename A::Scalar det(const Matrix<A>& a) {
  return a.determinant();
}
template <class A>
typename A::Scalar tr(const Matrix<A>& a) {
  return a.trace();
}
template <class A>
Tensor<typename A::Scalar> transpose(const Matrix<A>& a) {
  return a.transpose();
}
template <class A>
Tensor<typename A::Scalar> sym(const Matrix<A>& a) {
  return (a + a.transpose()) / 2.0;
}
template <class A>
Tensor<typename A::Scalar> identity(const Matrix<A>&) {
  return Tensor<typename A::Scalar>::Identity();
}
template <int n, class T>
T power(T x) {
  T result = x;
  for (int i = 1; i < n; ++i) result *= x;
  return result;
}
template <class T>
T ln(T x) {
  return std::log(x);
}
using std::exp;
using std::sinh;
using std::sqrt;

}  // namespace phynness::test
