#include "negative_curvature.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <vector>

#include "petsc_check.hpp"

namespace phynness {
namespace {

/// Products with PETSc matrices for vectors of Eigen.
class Operators {
 public:
  Operators(LinearSolver& preconditioner, Mat K) : _preconditioner(preconditioner), _K(K) {
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
  LinearSolver& _preconditioner;
  Mat _K;
  PetscVec _in, _out;
};

}  // namespace

NegativeCurvature most_negative_curvature(LinearSolver& preconditioner, Mat K, const Eigen::VectorXd& start) {
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

}  // namespace phynness
