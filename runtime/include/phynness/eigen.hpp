// Eigen's view of what phynness.hpp gives and takes: nothing is copied. Vectors and matrices of fixed size, and maps of
// such, are taken by phynness.hpp as they are.
#ifndef PHYNNESS_EIGEN_HPP
#define PHYNNESS_EIGEN_HPP

#include <Eigen/Core>
#include <phynness/phynness.hpp>

namespace phynness::rt {

/// One point or displacement a row, as phynness counts.
template <class T>
using Rows = Eigen::Matrix<T, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// A span of n x 3 numbers as a matrix.
template <class T>
Eigen::Map<const Rows<T>> rows(Span<const T> numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3};
}
template <class T>
Eigen::Map<Rows<T>> rows(Span<T> numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3};
}

/// A matrix as a span of its numbers. It has to be row-major, or columns would be taken for rows.
template <class T>
Span<T> span(Rows<T>& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}
template <class T>
Span<const T> span(const Rows<T>& matrix) {
  return {matrix.data(), static_cast<std::size_t>(matrix.size())};
}

}  // namespace phynness::rt

#endif
