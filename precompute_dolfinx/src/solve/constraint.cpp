#include "constraint.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/schema/round_tool.hpp>

namespace phynness {

Eigen::VectorXd Constraint::dependent(std::span<const double> state, const Eigen::VectorXd& prescribed) const {
  if (masters.empty()) return prescribed;
  const Eigen::VectorXd x = as_vector(state)(masters);
  return prescribed + M * x;
}

void Constraint::complete(std::span<double> state, const Eigen::VectorXd& prescribed) const {
  as_vector(state)(dofs) = dependent(state, prescribed);
}

void Constraint::condense(std::span<double> residual) const {
  if (masters.empty()) return;
  const Eigen::VectorXd r = as_vector(residual)(dofs), transferred = M.transpose() * r;
  as_vector(residual)(masters) += transferred;
}

std::vector<double> mean_weights(const Discretization& body, const SurfacePoint& center, double radius,
                                 const std::vector<char>& fixed) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> midpoint_of;
  for (int p = body.n_nodes(); p < body.n_points(); ++p)
    if (body.on_surface(p)) midpoint_of[std::minmax({body.edge(p)[0], body.edge(p)[1]})] = p;
  std::vector<double> weights(static_cast<std::size_t>(body.n_points()), 0.0);
  const Points nodes = body.points().topRows(body.n_nodes());
  double fixed_integral = 0;
  SurfaceTools(nodes, body.surface())
      .press(center, radius, !midpoint_of.empty(), [&](Eigen::Index t, std::span<const double> integrals) {
        const Eigen::RowVector3i corner = body.surface().row(t);
        for (int k = 0; k < 3; ++k) {
          const auto a = corner[k], b = corner[(k + 1) % 3];
          weights[a] += integrals[static_cast<std::size_t>(k)];
          if (!midpoint_of.empty())
            weights[midpoint_of.at(std::minmax({a, b}))] += integrals[static_cast<std::size_t>(k) + 3];
        }
        if (midpoint_of.empty())
          fixed_integral += schema::integrals_at_fixed(integrals.data(), [&](int k) { return fixed[corner[k]] != 0; });
      });
  double sum = 0;
  for (int p = 0; p < body.n_points(); ++p) {
    if (fixed[p]) weights[p] = 0;
    sum += weights[p];
  }
  for (auto& weight : weights) weight = sum > 0 ? weight / schema::weight_divisor(sum, fixed_integral) : 0;
  return weights;
}

namespace {

/// Tools that prescribe weighted means, sum_c B(t, c) a_c = q_t, of the displacements a_c of control points.
struct Means {
  std::vector<int> controls;                ///< distinct points of the body
  Eigen::MatrixXd B;                        ///< n_tools x n_controls
  std::vector<std::vector<double>> shapes;  ///< per control: factor of a_c in the displacement of every point (1 at
                                            ///< the control, 0 at other controls); empty: a control moves only itself
};

/// The values at all points of the P1 hat function on the surface around a node.
std::vector<double> hat_function(const Discretization& body, std::int32_t node, const std::vector<char>& fixed) {
  std::vector<double> weights(static_cast<std::size_t>(body.n_points()), 0.0);
  weights[static_cast<std::size_t>(node)] = 1;
  for (int p = body.n_nodes(); p < body.n_points(); ++p)
    if (const auto [a, b] = body.edge(p); !fixed[p] && body.on_surface(p) && (a == node || b == node)) weights[p] = 0.5;
  return weights;
}

Means means_of(const Discretization& body, const std::vector<SurfacePoint>& centers, double radius,
               const std::vector<char>& fixed) {
  std::vector<std::map<int, double>> rows;
  std::map<int, Eigen::Index> column_of;
  for (const auto& center : centers) {
    auto& weights_of_tool = rows.emplace_back();
    if (radius > 0) {
      const auto weights = mean_weights(body, center, radius, fixed);
      for (int p = 0; p < body.n_points(); ++p)
        if (weights[p] != 0) weights_of_tool[p] = weights[p];
    } else {
      for (std::size_t k = 0; k < 3; ++k)
        if (center.weights[k] > 0 && !fixed[center.nodes[k]]) weights_of_tool[center.nodes[k]] += center.weights[k];
    }
    if (weights_of_tool.empty())
      throw input_error("all nodes of a tool are fixed", "tool " + std::to_string(rows.size() - 1),
                        "touch a part of the surface that can move");
    for (const auto& [point, weight] : weights_of_tool) column_of.emplace(point, 0);
  }
  Means means;
  for (auto& [point, column] : column_of) {
    column = std::ssize(means.controls);
    means.controls.push_back(point);
    if (radius == 0) means.shapes.push_back(hat_function(body, point, fixed));
  }
  means.B = Eigen::MatrixXd::Zero(std::ssize(rows), std::ssize(means.controls));
  for (std::size_t t = 0; t < rows.size(); ++t)
    for (const auto& [point, weight] : rows[t]) means.B(static_cast<Eigen::Index>(t), column_of.at(point)) = weight;
  return means;
}

/// Selects one control per tool such that their columns of B are well conditioned, by complete pivoting.
std::vector<Eigen::Index> dependent_controls(Eigen::MatrixXd B) {
  // The smallest ratio of a pivot to the largest weight of its tool. Below it, the forces of the tools would be a
  // thousand times as large as their sum.
  constexpr double smallest_pivot = 1e-3;
  const Eigen::VectorXd largest = B.rowwise().lpNorm<Eigen::Infinity>();
  std::vector<Eigen::Index> dependent;
  for (Eigen::Index n = 0; n < B.rows(); ++n) {
    Eigen::Index row = 0, column = 0;
    const double ratio = (largest.cwiseInverse().asDiagonal() * B).cwiseAbs().maxCoeff(&row, &column);
    if (!(ratio >= smallest_pivot))
      throw input_error("two tools are at the same place",
                        std::to_string(n) + " of " + std::to_string(B.rows()) + " tools are independent",
                        "keep tools at least a tool radius apart");
    const Eigen::VectorXd factors = B.col(column) / B(row, column);
    const Eigen::RowVectorXd pivot = B.row(row);
    B -= factors * pivot;
    B.row(row).setZero();
    dependent.push_back(column);
  }
  return dependent;
}

}  // namespace

Constraint tool_constraint(const Discretization& body, const std::vector<SurfacePoint>& centers, double radius,
                           const std::vector<char>& fixed) {
  const Means means = means_of(body, centers, radius, fixed);
  const auto& B = means.B;
  const auto dependent = dependent_controls(B);
  std::vector<Eigen::Index> free_controls;
  for (Eigen::Index c = 0; c < B.cols(); ++c)
    if (std::find(dependent.begin(), dependent.end(), c) == dependent.end()) free_controls.push_back(c);
  // The displacements of all controls: a = C a_kept + D q.
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(B(Eigen::all, dependent)).inverse();
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(B.cols(), std::ssize(free_controls)),
                  D = Eigen::MatrixXd::Zero(B.cols(), B.rows());
  C(dependent, Eigen::all) = -inverse * B(Eigen::all, free_controls);
  D(dependent, Eigen::all) = inverse;
  for (std::size_t i = 0; i < free_controls.size(); ++i) C(free_controls[i], static_cast<Eigen::Index>(i)) = 1;

  std::vector<char> is_master(static_cast<std::size_t>(body.n_points()), 0);
  Constraint constraint;
  for (const auto c : free_controls) {
    const int point = means.controls[static_cast<std::size_t>(c)];
    is_master[static_cast<std::size_t>(point)] = 1;
    constraint.masters.insert(constraint.masters.end(), body.dofs(point).begin(), body.dofs(point).end());
  }
  // The factors of the controls for each dependent point.
  std::vector<Eigen::RowVectorXd> rows;
  const auto shape = [&](Eigen::Index c, int point) {
    const auto i = static_cast<std::size_t>(c);
    return means.shapes.empty() ? (means.controls[i] == point ? 1.0 : 0.0)
                                : means.shapes[i][static_cast<std::size_t>(point)];
  };
  for (int p = 0; p < body.n_points(); ++p) {
    if (is_master[static_cast<std::size_t>(p)]) continue;
    Eigen::RowVectorXd factors(B.cols());
    for (Eigen::Index c = 0; c < B.cols(); ++c) factors[c] = shape(c, p);
    if ((factors.array() == 0).all()) continue;
    constraint.dofs.insert(constraint.dofs.end(), body.dofs(p).begin(), body.dofs(p).end());
    rows.push_back(factors);
  }
  const auto n = static_cast<Eigen::Index>(constraint.dofs.size());
  constraint.G = Eigen::MatrixXd::Zero(n, 3 * B.rows());
  constraint.M = Eigen::MatrixXd::Zero(n, 3 * std::ssize(free_controls));
  for (Eigen::Index i = 0; i < std::ssize(rows); ++i) {
    const Eigen::RowVectorXd g = rows[static_cast<std::size_t>(i)] * D, m = rows[static_cast<std::size_t>(i)] * C;
    for (int k = 0; k < 3; ++k) {
      for (Eigen::Index t = 0; t < g.size(); ++t) constraint.G(3 * i + k, 3 * t + k) = g[t];
      for (Eigen::Index j = 0; j < m.size(); ++j) constraint.M(3 * i + k, 3 * j + k) = m[j];
    }
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
