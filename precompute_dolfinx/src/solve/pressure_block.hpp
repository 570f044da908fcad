// The pressure block of a mixed tangent, which equilibrates the pressures of a trial state.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "petsc_check.hpp"

namespace phynness {

/// Equilibrium of a mixed element is a saddle point: Pi(u, p) is a maximum in p and a minimum in u. With C = -K_pp and
/// r_p = dPi/dp,
///
///     Pi + r_p^T C^-1 r_p / 2
///
/// is the maximum of Pi over p for this u up to terms of third order in r_p. It is minimized like the energy of a
/// displacement element.
class PressureBlock {
 public:
  /// @param unknowns  rows of the pressures in the tangent; none for displacement elements
  explicit PressureBlock(std::vector<std::int32_t> unknowns) : _unknowns(std::move(unknowns)) {}

  bool empty() const { return _unknowns.empty(); }
  /// Copies the block of an assembled tangent, which is factorized at its first use. If it is not negative definite,
  /// the previous factors remain.
  void copy_from(Mat tangent);
  /// Discards the factors before a new solve, so that it does not depend on earlier ones.
  void reset();
  /// Whether some block since reset() was definite.
  bool is_definite();
  /// The pressure rows of a vector of unknowns.
  Eigen::VectorXd pressures_of(Vec unknowns) const;
  /// C^-1 r_p, the correction of the pressures; zero without a definite block.
  Eigen::VectorXd solve(const Eigen::VectorXd& r_p);

 private:
  using Factors = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>;
  void factorize();

  std::vector<std::int32_t> _unknowns;
  std::vector<std::int32_t> _position;  ///< positions of the block's entries in the values of the tangent
  Eigen::SparseMatrix<double> _block;
  std::unique_ptr<Factors> _factors, _reusable_factors;
  bool _is_unfactorized = false;
};

}  // namespace phynness
