#include "constraint.hpp"

#include <functional>

namespace phynness {

namespace {

/// Weights of all points: those of the nodes, and `at_middle` for middles of surface edges that end at one of them.
std::vector<double> with_middles(const Discretization& body, const TouchedNodes& touched,
                                 const std::vector<char>& fixed, const std::function<double(int point)>& at_middle) {
  std::vector<double> weights(body.n_points(), 0.0);
  for (std::size_t i = 0; i < touched.nodes.size(); ++i) weights[touched.nodes[i]] = touched.weights[i];
  for (int p = body.n_nodes(); p < body.n_points(); ++p) {
    const auto [a, b] = body.edge(p);
    if (!fixed[p] && body.on_surface(p) && (weights[a] != 0 || weights[b] != 0)) weights[p] = at_middle(p);
  }
  return weights;
}

}  // namespace

std::vector<std::int32_t> fixed_nodes(const Discretization& body, const std::vector<char>& fixed) {
  std::vector<std::int32_t> nodes;
  for (int i = 0; i < body.n_nodes(); ++i)
    if (fixed[i]) nodes.push_back(i);
  return nodes;
}

std::vector<double> tool_weights(const Discretization& body, ProbeKind kind, double radius, std::int32_t node,
                                 const std::vector<char>& fixed) {
  const bool patch = kind == ProbeKind::patch;
  const auto touched = touched_nodes(body.points().topRows(body.n_nodes()), body.surface(), fixed_nodes(body, fixed),
                                     node, patch ? radius : 0.0);
  return with_middles(body, touched, fixed, [&](int p) {
    return patch ? patch_weight((body.points().row(p) - body.points().row(node)).squaredNorm() / (radius * radius))
                 : 0.5;
  });
}

std::vector<double> patch_weights(const Discretization& body, double radius, const SurfacePoint& center,
                                  const std::vector<char>& fixed) {
  const auto touched =
      touched_nodes(body.points().topRows(body.n_nodes()), body.surface(), fixed_nodes(body, fixed), center, radius);
  Eigen::RowVector3d point = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    if (center.weights[k] > 0) point += center.weights[k] * body.points().row(center.nodes[k]);
  return with_middles(body, touched, fixed, [&](int p) {
    return touched.scale * patch_weight((body.points().row(p) - point).squaredNorm() / (radius * radius));
  });
}

Constraint tool_constraint(const Discretization& body, const std::vector<std::vector<double>>& weights_of_tools) {
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

std::vector<std::int32_t> displacement_dofs(const Discretization& body, const std::vector<char>& points) {
  std::vector<std::int32_t> dofs;
  for (int p = 0; p < body.n_points(); ++p)
    if (points[p]) dofs.insert(dofs.end(), body.dofs(p).begin(), body.dofs(p).end());
  return dofs;
}

std::vector<std::int32_t> fixed_dofs(const Discretization& body, const std::vector<char>& fixed) {
  auto dofs = displacement_dofs(body, fixed);
  if (body.has_directors())
    for (int p = body.n_nodes(); p < body.n_points(); ++p)
      if (fixed[p]) dofs.insert(dofs.end(), body.director_dofs(p).begin(), body.director_dofs(p).end());
  return dofs;
}

}  // namespace phynness
