// Leaves an unstable equilibrium in a reproducible direction.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "equilibrium.hpp"
#include "factorization.hpp"
#include "petsc_check.hpp"

namespace phynness {
namespace {

double size_of(const Discretization& body) {
  return (body.points().colwise().maxCoeff() - body.points().colwise().minCoeff()).norm();
}

/// A force on every free displacement that has no symmetry of any body. It is a smooth function of position, so that
/// the direction of buckling depends neither on the numbering of the nodes nor on rounding.
Eigen::VectorXd generic_force(const Discretization& body, const TangentMatrix& tangent, const Constraint& constraint,
                              const std::vector<char>& is_free) {
  std::vector<double> nodal(static_cast<std::size_t>(body.n_dofs()), 0.0);
  const Eigen::RowVector3d wave = Eigen::RowVector3d(3.1, 1.7, 2.3) / size_of(body);
  const Eigen::RowVector3d corner = body.points().colwise().minCoeff();
  for (int p = 0; p < body.n_points(); ++p)
    for (int k = 0; k < 3; ++k)
      if (const auto dof = body.dofs(p)[k]; dof >= 0)
        nodal[dof] = std::sin(wave.dot(body.points().row(p) - corner) + 1 + 0.7 * k);
  constraint.condense(nodal);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(tangent.n_unknowns());
  for (int i = 0; i < tangent.n_unknowns(); ++i)
    if (const auto dof = tangent.dof_of()[i]; is_free[dof]) force[i] = nodal[dof];
  return force;
}

/// Products with PETSc matrices for vectors of Eigen.
class Operators {
 public:
  Operators(Factorization& preconditioner, Mat K) : _preconditioner(preconditioner), _K(K) {
    PHYNNESS_PETSC(MatCreateVecs(K, _in.address(), _out.address()));
  }
  /// z = P^-1 q. @return false if the preconditioner gives no finite result
  bool precondition(const Eigen::VectorXd& q, Eigen::VectorXd& z) {
    WriteValues(_in).map() = q;
    if (!_preconditioner.solve(_in, _out)) return false;
    z = ReadValues(_out).map();
    return true;
  }
  Eigen::VectorXd multiply(const Eigen::VectorXd& z) {
    WriteValues(_in).map() = z;
    PHYNNESS_PETSC(MatMult(_K, _in, _out));
    return ReadValues(_out).map();
  }

 private:
  Factorization& _preconditioner;
  Mat _K;
  PetscVec _in, _out;
};

/// The direction of most negative curvature at an unstable equilibrium.
struct NegativeCurvature {
  Eigen::VectorXd direction;  ///< n; empty if no negative curvature was found
  double curvature = 0;       ///< v K v / v P v with the preconditioner's matrix P; negative
};

/// The eigenvector of K v = c P v with the smallest eigenvalue, by the Lanczos method in the inner product of P with
/// full reorthogonalization (Parlett 1998, doi:10.1137/1.9781611971163). P and K differ only in element tangents that
/// are not positive semidefinite, so that most eigenvalues are near 1 and a few steps suffice. With pressures, all
/// vectors are in the subspace in which the pressure equations hold; there both matrices are those of the displacements
/// with condensed pressures.
/// @pre K has a negative eigenvalue; otherwise all steps are executed before the result is empty
/// @param preconditioner  has factors of P
/// @param start  n; zero for prescribed displacements and for pressures. It determines the sign of the result, start .
///               v > 0, and which of several directions with the same curvature is found
NegativeCurvature most_negative_curvature(Factorization& preconditioner, Mat K, const Eigen::VectorXd& start) {
  constexpr int most_steps = 120;
  // Tolerance of the residual relative to the eigenvalue, so small that the direction does not depend on rounding.
  constexpr double tolerance = 1e-6;
  Operators operators(preconditioner, K);
  std::vector<Eigen::VectorXd> q, z;  // z = P^-1 q, q_i . z_j = 1 if i = j, else 0
  std::vector<double> diagonal, beside;

  NegativeCurvature found;
  Eigen::VectorXd w = start, P_w;
  if (!operators.precondition(w, P_w)) return found;
  double length = std::sqrt(std::max(0.0, w.dot(P_w)));
  for (int step = 0; step < most_steps && length > 0; ++step) {
    if (step > 0) beside.push_back(length);
    q.push_back(w / length);
    z.push_back(P_w / length);
    w = operators.multiply(z.back());
    diagonal.push_back(w.dot(z.back()));
    for (int twice = 0; twice < 2; ++twice)
      for (std::size_t i = 0; i < q.size(); ++i) w -= w.dot(z[i]) * q[i];
    if (!operators.precondition(w, P_w)) return found;
    length = std::sqrt(std::max(0.0, w.dot(P_w)));

    const auto n = static_cast<Eigen::Index>(diagonal.size());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
    ritz.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal.data(), n),
                                Eigen::Map<const Eigen::VectorXd>(beside.data(), n - 1));
    const double lowest = ritz.eigenvalues()[0];
    const Eigen::VectorXd weights = ritz.eigenvectors().col(0);
    const bool settled = length * std::abs(weights[n - 1]) < tolerance * std::abs(lowest);
    const bool last = step + 1 == most_steps || !(length > 0);
    if (!(lowest < 0) || !(settled || last)) continue;
    found.curvature = lowest;
    found.direction = Eigen::VectorXd::Zero(start.size());
    for (Eigen::Index i = 0; i < n; ++i) found.direction += weights[i] * z[static_cast<std::size_t>(i)];
    if (found.direction.dot(start) < 0) found.direction = -found.direction;
    break;
  }
  return found;
}

}  // namespace

bool Equilibrium::break_symmetry(Vec step) {
  constexpr double share = 1e-6;
  const auto force = generic_force(_body, _tangent, _constraint, _is_free);
  PetscVec b, z;
  PHYNNESS_PETSC(VecDuplicate(step, b.address()));
  PHYNNESS_PETSC(VecDuplicate(step, z.address()));
  WriteValues(b).map() = force;
  if (!_linear.solve(b, z)) return false;
  ++_counts.substitutions;
  PetscReal of_step = 0, of_z = 0;
  PHYNNESS_PETSC(VecNorm(step, NORM_INFINITY, &of_step));
  PHYNNESS_PETSC(VecNorm(z, NORM_INFINITY, &of_z));
  if (of_z > 0) PHYNNESS_PETSC(VecAXPY(step, share * of_step / of_z, z));
  return true;
}

bool Equilibrium::leave_saddle() {
  const auto saddle = _state;
  const double size = size_of(_body);
  _tangent.assemble(_body, _state, Convexity::strictly);
  ++_counts.tangents;
  _factors_are_convex = true;
  _quasi_newton.clear();
  _pressures.set(_tangent.matrix());
  if (!factorize() || (!_pressures.empty() && !_pressures.is_definite())) return false;
  const auto found =
      most_negative_curvature(_linear, _tangent.exact(), generic_force(_body, _tangent, _constraint, _is_free));
  if (found.direction.size() == 0) return false;

  double largest = 0;
  for (int p = 0; p < _body.n_points(); ++p)
    for (const auto dof : _body.dofs(p))
      if (dof >= 0 && _is_free[dof]) largest = std::max(largest, std::abs(found.direction[_tangent.unknown_of()[dof]]));
  if (!(largest > 0)) return false;
  const auto merit_at = [&](double length) {
    _state = saddle;
    for (int i = 0; i < _tangent.n_unknowns(); ++i)
      _state[_tangent.dof_of()[i]] += length / largest * found.direction[i];
    _constraint.complete(_state, _held);
    evaluate_residual();
    const bool valid = std::isfinite(free_norm()) && (!_body.forms().checks_jacobian || _body.min_jacobian(_state) > 0);
    return valid ? merit() : std::numeric_limits<double>::infinity();
  };
  // Lengths in units of the body: from far above rounding to visible bending.
  constexpr double shortest = 1e-5, longest = 0.1;
  const double at_saddle = merit_at(0);
  double best = 0, lowest = at_saddle;
  if (!std::isfinite(at_saddle)) return false;
  for (const double sign : {1.0, -1.0}) {
    double here = 0, before = at_saddle;
    for (double length = shortest * size; length <= longest * size; length *= 2) {
      const double now = merit_at(sign * length);
      if (!(now < before)) {
        // The decrease of the energy in the first steps may be below rounding.
        if (length > 1e-3 * size || !std::isfinite(now)) break;
        continue;
      }
      before = now;
      here = sign * length;
    }
    // The opposite direction is taken only if its energy is lower by more than rounding, so that a symmetric body
    // always takes the first direction.
    if (before < lowest - (sign < 0 ? 1e-3 * (at_saddle - lowest) : 0)) {
      lowest = before;
      best = here;
    }
  }
  merit_at(best);
  // The threshold is several hundred times the rounding error of the energy.
  return at_saddle - lowest > 1e-13 * std::abs(at_saddle);
}

}  // namespace phynness
