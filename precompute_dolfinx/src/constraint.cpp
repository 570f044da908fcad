#include "constraint.hpp"

#include <Eigen/Eigenvalues>

namespace phynness {

std::vector<double> tool_weights(const Discretization& body, ProbeKind kind, double radius, std::int32_t node,
                                 const std::vector<char>& fixed) {
  std::vector<double> weights(body.n_points(), 0.0);
  for (int p = 0; p < body.n_points(); ++p) {
    if (fixed[p] || !body.on_surface(p)) continue;
    if (kind == ProbeKind::patch) {
      const double s2 = (body.points().row(p) - body.points().row(node)).squaredNorm() / (radius * radius);
      // Points on the rim stay free whichever way rounding goes: to hold them at 0 is another scene.
      if (s2 < 1 - 1e-9) weights[p] = (1 - s2) * (1 - s2);
    } else if (p >= body.n_nodes()) {
      const auto [a, b] = body.edge(p);
      if (a == node || b == node) weights[p] = 0.5;
    }
  }
  weights[node] = 1;
  return weights;
}

Constraint tool_constraint(const Discretization& body,
                           const std::vector<std::vector<double>>& weights_of_tools) {
  const auto n_tools = static_cast<int>(weights_of_tools.size());
  std::vector<int> touched;
  for (int p = 0; p < body.n_points(); ++p)
    for (const auto& weights : weights_of_tools)
      if (weights[p] != 0) {
        touched.push_back(p);
        break;
      }
  Constraint constraint;
  constraint.G = Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(touched.size()), 3 * n_tools);
  for (std::size_t i = 0; i < touched.size(); ++i)
    for (int k = 0; k < 3; ++k) {
      constraint.dofs.push_back(body.dofs(touched[i])[k]);
      for (int t = 0; t < n_tools; ++t)
        constraint.G(3 * static_cast<Eigen::Index>(i) + k, 3 * t + k) = weights_of_tools[t][touched[i]];
    }
  return constraint;
}

std::vector<char> fixed_points(const Discretization& body, std::span<const std::int32_t> fixed_nodes) {
  std::vector<char> fixed(body.n_points(), 0);
  for (const auto node : fixed_nodes) fixed[node] = 1;
  for (int p = body.n_nodes(); p < body.n_points(); ++p)
    fixed[p] = fixed[body.edge(p)[0]] && fixed[body.edge(p)[1]] ? 1 : 0;
  return fixed;
}

bool hold_the_body(const Discretization& body, const std::vector<char>& fixed) {
  std::vector<int> held;
  for (int p = 0; p < body.n_points(); ++p)
    if (fixed[p]) held.push_back(p);
  if (held.size() < 3) return false;
  Points at = body.points()(held, Eigen::all);
  at.rowwise() -= Eigen::RowVector3d(at.colwise().mean());
  // Root mean square distances from the best plane, within it from the best line, and along that line.
  const Eigen::Matrix3d spread = at.transpose() * at / static_cast<double>(held.size());
  const auto squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const Eigen::RowVector3d extent = body.points().colwise().maxCoeff() - body.points().colwise().minCoeff();
  return squares[1] > 1e-12 * extent.squaredNorm();
}

std::vector<std::int32_t> displacement_dofs(const Discretization& body, const std::vector<char>& points) {
  std::vector<std::int32_t> dofs;
  for (int p = 0; p < body.n_points(); ++p)
    if (points[p]) dofs.insert(dofs.end(), body.dofs(p).begin(), body.dofs(p).end());
  return dofs;
}

}  // namespace phynness
