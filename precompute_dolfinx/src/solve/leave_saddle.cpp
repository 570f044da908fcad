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

/// A force without symmetries on every free displacement. It is a smooth function of position, so that the direction of
/// buckling depends neither on the numbering of the nodes nor on rounding.
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
/// @pre K has a negative eigenvalue; otherwise the result is empty after all steps
/// @param preconditioner  has factors of P
/// @param start  n; zero for prescribed displacements and for pressures. It determines the sign of the result (start .
/// v >
///               0) and the choice among directions with the same curvature
NegativeCurvature most_negative_curvature(Factorization& preconditioner, Mat K, const Eigen::VectorXd& start) {
  constexpr int most_steps = 120;
  // Tolerance of the residual relative to the eigenvalue, so small that the direction does not depend on rounding.
  constexpr double tolerance = 1e-6;
  Operators operators(preconditioner, K);
  std::vector<Eigen::VectorXd> q, z;  // z = P^-1 q, q_i . z_j = 1 if i = j, else 0
  std::vector<double> diagonal, off_diagonal;

  NegativeCurvature result;
  Eigen::VectorXd w = start, P_w;
  if (!operators.precondition(w, P_w)) return result;
  double norm = std::sqrt(std::max(0.0, w.dot(P_w)));
  for (int step = 0; step < most_steps && norm > 0; ++step) {
    if (step > 0) off_diagonal.push_back(norm);
    q.push_back(w / norm);
    z.push_back(P_w / norm);
    w = operators.multiply(z.back());
    diagonal.push_back(w.dot(z.back()));
    for (int repetition = 0; repetition < 2; ++repetition)
      for (std::size_t i = 0; i < q.size(); ++i) w -= w.dot(z[i]) * q[i];
    if (!operators.precondition(w, P_w)) return result;
    norm = std::sqrt(std::max(0.0, w.dot(P_w)));

    const auto n = static_cast<Eigen::Index>(diagonal.size());
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz;
    ritz.computeFromTridiagonal(Eigen::Map<const Eigen::VectorXd>(diagonal.data(), n),
                                Eigen::Map<const Eigen::VectorXd>(off_diagonal.data(), n - 1));
    const double smallest_eigenvalue = ritz.eigenvalues()[0];
    const Eigen::VectorXd weights = ritz.eigenvectors().col(0);
    const bool is_converged = norm * std::abs(weights[n - 1]) < tolerance * std::abs(smallest_eigenvalue);
    const bool is_last_step = step + 1 == most_steps || !(norm > 0);
    if (!(smallest_eigenvalue < 0) || !(is_converged || is_last_step)) continue;
    result.curvature = smallest_eigenvalue;
    result.direction = Eigen::VectorXd::Zero(start.size());
    for (Eigen::Index i = 0; i < n; ++i) result.direction += weights[i] * z[static_cast<std::size_t>(i)];
    if (result.direction.dot(start) < 0) result.direction = -result.direction;
    break;
  }
  return result;
}

}  // namespace

bool Equilibrium::break_symmetry(Vec step) {
  constexpr double relative_size = 1e-6;
  const auto force = generic_force(_body, _tangent, _constraint, _is_free);
  PetscVec load, perturbation;
  PHYNNESS_PETSC(VecDuplicate(step, load.address()));
  PHYNNESS_PETSC(VecDuplicate(step, perturbation.address()));
  WriteValues(load).map() = force;
  if (!_factorization.solve(load, perturbation)) return false;
  ++_counts.substitutions;
  PetscReal step_size = 0, perturbation_size = 0;
  PHYNNESS_PETSC(VecNorm(step, NORM_INFINITY, &step_size));
  PHYNNESS_PETSC(VecNorm(perturbation, NORM_INFINITY, &perturbation_size));
  if (perturbation_size > 0) PHYNNESS_PETSC(VecAXPY(step, relative_size * step_size / perturbation_size, perturbation));
  return true;
}

bool Equilibrium::leave_saddle() {
  const auto saddle = _state;
  const double size = size_of(_body);
  _tangent.assemble(_body, _state, Convexity::strictly);
  ++_counts.tangents;
  _factors_are_convex = true;
  _quasi_newton.clear();
  _pressures.copy_from(_tangent.matrix());
  if (!factorize() || (!_pressures.empty() && !_pressures.is_definite())) return false;
  const auto curvature =
      most_negative_curvature(_factorization, _tangent.exact(), generic_force(_body, _tangent, _constraint, _is_free));
  if (curvature.direction.size() == 0) return false;

  double largest_component = 0;
  for (int p = 0; p < _body.n_points(); ++p)
    for (const auto dof : _body.dofs(p))
      if (dof >= 0 && _is_free[dof])
        largest_component = std::max(largest_component, std::abs(curvature.direction[_tangent.unknown_of()[dof]]));
  if (!(largest_component > 0)) return false;
  const auto merit_at = [&](double length) {
    _state = saddle;
    for (int i = 0; i < _tangent.n_unknowns(); ++i)
      _state[_tangent.dof_of()[i]] += length / largest_component * curvature.direction[i];
    _constraint.complete(_state, _prescribed);
    evaluate_residual();
    const bool valid =
        std::isfinite(free_residual_norm()) && (!_body.forms().checks_jacobian || _body.min_jacobian(_state) > 0);
    return valid ? merit() : std::numeric_limits<double>::infinity();
  };
  // Lengths in units of the body: from far above rounding to visible bending.
  constexpr double shortest = 1e-5, longest = 0.1;
  const double at_saddle = merit_at(0);
  double lowest_length = 0, lowest_merit = at_saddle;
  if (!std::isfinite(at_saddle)) return false;
  for (const double sign : {1.0, -1.0}) {
    double best_length = 0, best_merit = at_saddle;
    for (double length = shortest * size; length <= longest * size; length *= 2) {
      const double trial_merit = merit_at(sign * length);
      if (!(trial_merit < best_merit)) {
        // The decrease of the energy in the first steps may be below rounding.
        if (length > 1e-3 * size || !std::isfinite(trial_merit)) break;
        continue;
      }
      best_merit = trial_merit;
      best_length = sign * length;
    }
    // The opposite direction is taken only if its energy is lower by more than rounding, so that a symmetric body
    // always takes the first direction.
    if (best_merit < lowest_merit - (sign < 0 ? 1e-3 * (at_saddle - lowest_merit) : 0)) {
      lowest_merit = best_merit;
      lowest_length = best_length;
    }
  }
  merit_at(lowest_length);
  // The threshold is several hundred times the rounding error of the energy.
  return at_saddle - lowest_merit > 1e-13 * std::abs(at_saddle);
}

}  // namespace phynness
