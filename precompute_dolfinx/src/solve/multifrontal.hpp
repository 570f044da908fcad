// LDL^T of a sparse symmetric matrix on one process, without pivoting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace phynness {

/// Multifrontal factorization (Duff & Reid 1983, doi:10.1145/356044.356047). Rows with the same pattern (those of a
/// node) form a group, and groups are ordered by nested dissection. Fronts are amalgamated with their parents if this
/// adds few zeros, so that nearly all operations are products of dense matrices.
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
  int negative_pivots() const { return _negative_pivots; }

 private:
  /// A dense lower triangle: its first columns are eliminated, and the contribution block is added to the parent.
  struct Front {
    int first;                  ///< elimination step of the first pivot
    int pivots, size;           ///< numbers of eliminated columns, and of all columns
    int level;                  ///< distance from the root
    std::size_t factors;        ///< position of the columns of L (size x pivots) in _factors
    std::size_t last_entry;     ///< end of the front's entries in _entries
    std::vector<int> row;       ///< elimination steps of the rows below the pivots
    std::vector<int> position;  ///< position of each of these rows in the parent's front
    std::vector<int> children;
    int n_below() const { return size - pivots; }
  };
  struct Groups;
  void build_fronts(const Groups& groups);
  void find_entries(std::span<const std::int32_t> row_start, std::span<const std::int32_t> column);
  void gather(Front& front, std::vector<double>& from, double* contribution);
  bool eliminate(Front& front, double* contribution);

  std::vector<int> _order;  ///< row of A of each elimination step
  std::vector<Front> _fronts;
  /// The positions of an entry of the lower triangle in the values and in _factors.
  struct Entry {
    std::int32_t from;
    std::size_t to;
  };
  std::vector<Entry> _entries;
  std::vector<double> _factors;
  std::vector<double> _stack[2];  ///< contribution blocks of fronts of even and odd level
  std::size_t _stack_top[2] = {0, 0};
  std::vector<double> _scaled_panel;  ///< L D of the eliminated columns of a front
  std::vector<double> _x, _contribution_rhs;
  int _negative_pivots = 0;
};

}  // namespace phynness
