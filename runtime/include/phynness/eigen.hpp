// Conversions between spans of phynness.hpp and matrices of Eigen, without copies. Vectors and matrices of fixed size,
// and maps of them, need no conversion: phynness.hpp accepts them directly.
#ifndef PHYNNESS_EIGEN_HPP
#define PHYNNESS_EIGEN_HPP

#include <Eigen/Core>
#include <phynness/phynness.hpp>

namespace phynness::rt {

/// One point or displacement per row, row by row in memory, as phynness stores them.
template <class T>
using Rows = Eigen::Matrix<T, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// A span of 3 n numbers as an n x 3 matrix.
template <class T>
Eigen::Map<const Rows<T>> rows(Span<const T> numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3};
}
template <class T>
Eigen::Map<Rows<T>> rows(Span<T> numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3};
}

/// A matrix as a span of its numbers. Only row-major matrices are accepted, because phynness stores rows.
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
