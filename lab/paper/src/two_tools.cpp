#include "two_tools.hpp"

#include <algorithm>
#include <cmath>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/probed_states.hpp>

#include "errors.hpp"

namespace phynness::study {
namespace {

Vec3 scaled(const Vec3& v, double s) { return {s * v[0], s * v[1], s * v[2]}; }
double length_of(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
double distance(const Vec3& a, const Vec3& b) { return length_of({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

/// All predictions for one depth, at the output nodes that count.
struct State {
  double depth_m = 0;
  Points finite_elements, paper, coupled, linear;
  std::array<Vec3, 2> force_FE{}, force_coupled{}, force_linear{}, force_alone{};
};

Points at_output(const Points& all, const std::vector<std::int32_t>& output) {
  Points some(static_cast<Eigen::Index>(output.size()), 3);
  for (Eigen::Index i = 0; i < some.rows(); ++i) some.row(i) = all.row(output[static_cast<std::size_t>(i)]);
  return some;
}

}  // namespace

PairDraw draw_pair(const Model& model, std::mt19937_64& random) {
  const auto index = [&](std::size_t n) { return static_cast<std::size_t>(uniform(random) * static_cast<double>(n)); };
  PairDraw pair;
  pair.a = model.nodes[index(model.nodes.size())].node;
  do pair.b = model.nodes[index(model.nodes.size())].node;
  while (pair.b == pair.a);
  const double share = 1 - uniform(random);
  pair.first = model.directions[index(model.directions.size())];
  pair.second = scaled(model.directions[index(model.directions.size())], share);
  return pair;
}

ToolPair measure_pair(ProbeSolver& solver, const PairDraw& pair, const std::vector<double>& depths_m,
                      const NamedOrgan& networks, const NamedOrgan& ours) {
  const auto& output = networks.model().output;
  solver.touch({pair.a, pair.b});
  const auto counts = counted_nodes(networks.model(), {pair.a, pair.b});
  std::vector<State> states;
  double largest_force = 0, largest_u = 0;
  solver.follow({pair.first, pair.second}, depths_m, false, [&](std::size_t i, const Response& response) {
    if (response.status != Status::converged) return false;
    State state;
    state.depth_m = depths_m[i];
    const std::vector<Vec3> d{scaled(pair.first, depths_m[i]), scaled(pair.second, depths_m[i])};
    state.finite_elements = at_output(response.displacement_m, output);
    state.paper = networks.blend({pair.a, pair.b}, d).displacement_m;
    std::vector<phn_tool> tools;
    for (std::size_t t = 0; t < 2; ++t)
      tools.push_back({{t == 0 ? pair.a : pair.b, -1, -1}, {1, 0, 0}, {d[t][0], d[t][1], d[t][2]}});
    const auto coupled = ours.hold(tools);
    state.coupled = coupled.displacement_m;
    const Eigen::Matrix<double, 6, 1> both{d[0][0], d[0][1], d[0][2], d[1][0], d[1][1], d[1][2]};
    const Eigen::VectorXd u = solver.rest().sensitivity * both, f = solver.rest().stiffness_N_per_m * both;
    state.linear = at_output(Eigen::Map<const Points>(u.data(), u.size() / 3, 3), output);
    for (std::size_t t = 0; t < 2; ++t) {
      const auto at = static_cast<Eigen::Index>(3 * t);
      state.force_FE[t] = response.force_N[t];
      state.force_coupled[t] = *coupled.force_N[t];
      state.force_linear[t] = {f[at], f[at + 1], f[at + 2]};
      state.force_alone[t] = ours.force(t == 0 ? pair.a : pair.b, d[t]);
      largest_force = std::max(largest_force, length_of(state.force_FE[t]));
    }
    for (Eigen::Index k = 0; k < state.finite_elements.rows(); ++k)
      if (counts[static_cast<std::size_t>(k)]) largest_u = std::max(largest_u, state.finite_elements.row(k).norm());
    states.push_back(std::move(state));
    return true;
  });
  ToolPair out{pair.a, pair.b, 0, pair.first, pair.second, {}};
  const auto& nodes = networks.mesh().nodes;
  out.distance_m = (nodes.row(pair.a) - nodes.row(pair.b)).norm();
  for (const auto& state : states) {
    TwoToolErrors errors;
    errors.depth_m = state.depth_m;
    const auto of = [&](const Points& said, double& mean, double& max, Histogram& histogram) {
      Errors e;
      for (Eigen::Index k = 0; k < said.rows(); ++k)
        if (counts[static_cast<std::size_t>(k)]) e.add((said.row(k) - state.finite_elements.row(k)).norm(), largest_u);
      mean = e.mean();
      max = e.max();
      histogram = e.histogram();
    };
    of(state.paper, errors.paper_mean, errors.paper_max, errors.paper);
    of(state.coupled, errors.coupled_mean, errors.coupled_max, errors.coupled);
    of(state.linear, errors.linear_mean, errors.linear_max, errors.linear);
    const auto worse = [&](const std::array<Vec3, 2>& said) {
      return largest_force > 0
                 ? std::max(distance(said[0], state.force_FE[0]), distance(said[1], state.force_FE[1])) / largest_force
                 : 0.0;
    };
    errors.coupled_force = worse(state.force_coupled);
    errors.linear_force = worse(state.force_linear);
    errors.alone_force = worse(state.force_alone);
    out.depths.push_back(std::move(errors));
  }
  return out;
}

}  // namespace phynness::study
