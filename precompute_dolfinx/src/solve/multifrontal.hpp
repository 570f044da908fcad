// LDL^T of a sparse symmetric matrix on one process, without pivoting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace phynness {

/// Multifrontal factorization (Duff & Reid 1983, doi:10.1145/356044.356047). Rows with the same pattern, which are
/// those of a node, are ordered together by nested dissection, and fronts that fit nearly into their parents are merged
/// into them, so that nearly all operations are products of dense matrices.
class Multifrontal {
 public:
  /// Orders the rows and finds the pattern of the factors.
  /// @param row_start, column  all entries of the symmetric pattern by rows, columns ascending, the diagonal included
  Multifrontal(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column);

  /// @param values  of all entries, in the order of the pattern
  /// @return false if a pivot is zero or not finite; there are no factors then
  bool factorize(std::span<const double> values);
  /// x = A^-1 b. The two may be the same memory. @pre factorize() has succeeded
  void solve(std::span<const double> b, std::span<double> x);
  /// Number of negative pivots. @pre factorize() has succeeded
  int negative_pivots() const { return _negative; }

 private:
  /// A dense lower triangle: its first columns are eliminated in it, and the rest is added to the parent's.
  struct Front {
    int first;               ///< row of A, in the order of elimination, of the first pivot
    int pivots, size;        ///< columns that are eliminated, and all
    int level;               ///< distance from the root
    std::size_t factors;     ///< position of its columns of L (size x pivots) in _factors
    std::size_t last_entry;  ///< end of its entries in _entries
    std::vector<int> row;    ///< rows of A below the pivots
    std::vector<int> place;  ///< of each of these, the place in the parent's front
    std::vector<int> children;
    int rest() const { return size - pivots; }
  };
  struct Groups;
  void build_fronts(const Groups& groups);
  void find_entries(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column);
  void gather(Front& front, std::vector<double>& from, double* rest);
  bool eliminate(Front& front, double* rest);

  std::vector<int> _order;  ///< row of A that is eliminated at each step
  std::vector<Front> _fronts;
  /// Entries of the lower triangle: position in the values, and in _factors.
  struct Entry {
    std::int32_t from;
    std::size_t to;
  };
  std::vector<Entry> _entries;
  std::vector<double> _factors;
  std::vector<double> _stack[2];  ///< rests of fronts of even and odd level that wait for their parents
  std::size_t _top[2] = {0, 0};
  std::vector<double> _scaled;  ///< L D of the pivots of a front
  std::vector<double> _x, _below;
  int _negative = 0;
};

}  // namespace phynness
