#include <Eigen/LU>
#include <algorithm>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/held_points.hpp>

namespace phynness {
namespace {

/// Relative size of the last step. Convergence is quadratic, so that after such a step only the error of the solver
/// remains.
constexpr double settled_step = 1e-6;
constexpr int most_solves = 25;

/// Weights of the touched nodes in the tools' points: 3 n_tools x 3 n_nodes.
Eigen::MatrixXd point_weights(const std::vector<PointTool>& tools, const std::vector<std::int32_t>& nodes) {
  Eigen::MatrixXd weights =
      Eigen::MatrixXd::Zero(3 * static_cast<Eigen::Index>(tools.size()), 3 * static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t t = 0; t < tools.size(); ++t)
    for (std::size_t i = 0; i < tools[t].nodes.size(); ++i) {
      const auto at = std::find(nodes.begin(), nodes.end(), tools[t].nodes[i]) - nodes.begin();
      for (int k = 0; k < 3; ++k) weights(3 * static_cast<Eigen::Index>(t) + k, 3 * at + k) += tools[t].weights[i];
    }
  return weights;
}

std::vector<Vec3> per_tool(const Eigen::VectorXd& values) {
  std::vector<Vec3> rows(static_cast<std::size_t>(values.size() / 3));
  for (std::size_t t = 0; t < rows.size(); ++t)
    for (int k = 0; k < 3; ++k) rows[t][k] = values[3 * static_cast<Eigen::Index>(t) + k];
  return rows;
}

/// The tools without fixed nodes. @throws Error (input) if nothing is left of one
std::vector<PointTool> without_fixed(const ProbeSolver& solver, const std::vector<PointTool>& tools) {
  std::vector<PointTool> free;
  for (const auto& tool : tools) {
    auto& kept = free.emplace_back(PointTool{{}, {}, tool.displacement_m});
    for (std::size_t i = 0; i < tool.nodes.size(); ++i) {
      if (tool.weights[i] == 0 || solver.is_fixed(tool.nodes[i])) continue;
      kept.nodes.push_back(tool.nodes[i]);
      kept.weights.push_back(tool.weights[i]);
    }
    if (kept.nodes.empty())
      throw input_error("all nodes of a tool are fixed", "tool " + std::to_string(free.size() - 1),
                        "touch a part of the surface that can move");
  }
  return free;
}

HeldPoints hold_patches(ProbeSolver& solver, const std::vector<PointTool>& tools, int increments, bool tangents) {
  std::vector<SurfacePoint> centers;
  std::vector<Vec3> displacements;
  Eigen::VectorXd d(3 * static_cast<Eigen::Index>(tools.size()));
  for (const auto& tool : tools) {
    SurfacePoint& center = centers.emplace_back();
    center.nodes = {-1, -1, -1};
    for (std::size_t i = 0; i < tool.nodes.size(); ++i) {
      center.nodes.at(i) = tool.nodes[i];
      center.weights.at(i) = tool.weights[i];
    }
    d.segment<3>(3 * static_cast<Eigen::Index>(displacements.size())) =
        Eigen::Vector3d(tool.displacement_m[0], tool.displacement_m[1], tool.displacement_m[2]);
    displacements.push_back(tool.displacement_m);
  }
  solver.touch_patches(centers);
  HeldPoints held;
  held.linear_force_N = per_tool(solver.rest().stiffness_N_per_m * d);
  const Eigen::VectorXd u = solver.rest().sensitivity * d;
  held.linear_displacement_m = Eigen::Map<const Points>(u.data(), u.size() / 3, 3);
  held.response = solver.solve(displacements, increments, tangents);
  held.solves = 1;
  return held;
}

}  // namespace

HeldPoints hold_points(ProbeSolver& solver, const std::vector<PointTool>& all_tools, int increments, bool tangents) {
  const auto tools = without_fixed(solver, all_tools);
  if (solver.holds_patches()) return hold_patches(solver, all_tools, increments, tangents);
  std::vector<std::int32_t> nodes;
  for (const auto& tool : tools)
    for (const auto node : tool.nodes)
      if (std::find(nodes.begin(), nodes.end(), node) == nodes.end()) nodes.push_back(node);
  solver.touch(nodes);
  const Eigen::MatrixXd B = point_weights(tools, nodes);
  Eigen::VectorXd target(B.rows());
  for (std::size_t t = 0; t < tools.size(); ++t)
    for (int k = 0; k < 3; ++k) target[3 * static_cast<Eigen::Index>(t) + k] = tools[t].displacement_m[k];

  HeldPoints held;
  Eigen::VectorXd q = Eigen::VectorXd::Zero(B.cols()), f = q, F = Eigen::VectorXd::Zero(B.rows());
  Eigen::MatrixXd stiffness = solver.rest().stiffness_N_per_m;
  int iterations = 0, cutbacks = 0;
  for (bool settled = false; !settled && held.solves < most_solves; ++held.solves) {
    // B (q + step) = target,  f + stiffness step = B^T F
    const Eigen::PartialPivLU<Eigen::MatrixXd> factors(stiffness);
    const Eigen::MatrixXd moved = factors.solve(B.transpose());
    const Eigen::VectorXd balance = factors.solve(f);
    F = (B * moved).partialPivLu().solve(target - B * q + B * balance);
    const Eigen::VectorXd step = moved * F - balance;
    q += step;
    if (held.solves == 0) {
      held.linear_force_N = per_tool(F);
      const Eigen::VectorXd u = solver.rest().sensitivity * q;
      held.linear_displacement_m = Eigen::Map<const Points>(u.data(), u.size() / 3, 3);
    }
    settled = held.solves > 0 && step.norm() <= settled_step * q.norm();
    std::vector<Vec3> displacement(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int k = 0; k < 3; ++k) displacement[i][k] = q[3 * static_cast<Eigen::Index>(i) + k];
    held.response = solver.solve(displacement, increments, true);
    iterations += held.response.iterations;
    cutbacks += held.response.cutbacks;
    if (held.response.status != Status::converged) break;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (int k = 0; k < 3; ++k) f[3 * static_cast<Eigen::Index>(i) + k] = held.response.force_N[i][k];
    stiffness = held.response.tangent_N_per_m;
    if (!settled && held.solves + 1 == most_solves) held.response.status = Status::diverged;
  }
  held.response.iterations = iterations;
  held.response.cutbacks = cutbacks;
  held.response.force_N = per_tool(F);
  return held;
}

}  // namespace phynness
