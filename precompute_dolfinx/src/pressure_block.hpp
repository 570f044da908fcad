// The pressure's own block of a mixed tangent: what the pressures of a trial state would still change.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "petsc_check.hpp"

namespace phynness {

/// A mixed element is a saddle point: the stored energy Pi(u, p) is greatest in p and least in u. With C =
/// -K_pp,
///
///     Pi + r_p^T C^-1 r_p / 2
///
/// is what Pi would be with the best p for this u, but for terms of third order in r_p = dPi/dp; so it can be
/// descended like the energy of a displacement element.
class PressureBlock {
 public:
  /// @param unknowns  rows of the pressures in the tangent; none for displacement elements
  explicit PressureBlock(std::vector<std::int32_t> unknowns) : _unknowns(std::move(unknowns)) {}

  bool empty() const { return _unknowns.empty(); }
  /// Takes the block out of an assembled tangent; factorized when it is first used. If it is not negative
  /// definite (neo_hookean.py says when), the one before stays.
  void set(Mat tangent);
  /// Before a new solve, which must not depend on what was solved before.
  void forget();
  /// False as long as no block was definite.
  bool is_definite();
  /// The pressures' part of a vector of unknowns.
  Eigen::VectorXd part(Vec unknowns) const;
  /// C^-1 r_p: what to add to the pressures; zero as long as there is no definite block.
  Eigen::VectorXd solve(const Eigen::VectorXd& r_p);

 private:
  using Factors = Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>>;
  void factorize();

  std::vector<std::int32_t> _unknowns;
  std::vector<std::int32_t> _position;  ///< of the block's entries in the tangent's values
  Eigen::SparseMatrix<double> _block;
  std::unique_ptr<Factors> _factors, _spare;
  bool _is_new = false;
};

}  // namespace phynness
