#include <Eigen/Eigenvalues>
#include <algorithm>
#include <phynness/formats/tool.hpp>

namespace phynness {

TouchedNodes touched_nodes(const Points& nodes, const Triangles& surface, std::span<const std::int32_t> fixed,
                           std::int32_t node, double tool_radius) {
  if (!(tool_radius > 0)) return {{node}, {1.0}};
  const auto weight = [&](std::int32_t i) {
    return patch_weight((nodes.row(i) - nodes.row(node)).squaredNorm() / (tool_radius * tool_radius));
  };
  // Flooding over triangles: as often as the patch is triangles across, which is few.
  std::vector<char> reached(static_cast<std::size_t>(nodes.rows()), 0);
  reached[static_cast<std::size_t>(node)] = 1;
  for (bool grows = true; grows;) {
    grows = false;
    for (Eigen::Index t = 0; t < surface.rows(); ++t) {
      const auto is_reached = [&](int k) { return reached[static_cast<std::size_t>(surface(t, k))] != 0; };
      if (!is_reached(0) && !is_reached(1) && !is_reached(2)) continue;
      for (int k = 0; k < 3; ++k)
        if (!is_reached(k) && weight(surface(t, k)) > 0) {
          reached[static_cast<std::size_t>(surface(t, k))] = 1;
          grows = true;
        }
    }
  }
  TouchedNodes touched;
  for (std::int32_t i = 0; i < nodes.rows(); ++i) {
    if (!reached[static_cast<std::size_t>(i)]) continue;
    if (i != node && std::binary_search(fixed.begin(), fixed.end(), i)) continue;
    touched.nodes.push_back(i);
    touched.weights.push_back(i == node ? 1.0 : weight(i));
  }
  return touched;
}

bool hold_the_body(const Points& nodes, std::span<const std::int32_t> fixed) {
  if (fixed.size() < 3) return false;
  Points at(static_cast<Eigen::Index>(fixed.size()), 3);
  for (std::size_t i = 0; i < fixed.size(); ++i) at.row(static_cast<Eigen::Index>(i)) = nodes.row(fixed[i]);
  at.rowwise() -= Eigen::RowVector3d(at.colwise().mean());
  // Mean square distances from the best plane, within it from the best line, and along that line.
  const Eigen::Matrix3d spread = at.transpose() * at / static_cast<double>(fixed.size());
  const auto squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread, Eigen::EigenvaluesOnly).eigenvalues();
  const Eigen::RowVector3d extent = nodes.colwise().maxCoeff() - nodes.colwise().minCoeff();
  return squares[1] > 1e-12 * extent.squaredNorm();
}

}  // namespace phynness
