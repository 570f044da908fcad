#include <algorithm>
#include <cmath>
#include <ctime>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/probe_points.hpp>
#include <phynness/schema/body_grammar.hpp>
#include <phynness/validation/named_organ.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/several_tools.hpp>

#include "packed.hpp"
#include "shared_work.hpp"
#include "tool_rays.hpp"

namespace phynness {
namespace {

constexpr double depth_fraction = 0.5;
constexpr int increments = 4, max_steps = 100, max_attempts = 1000;
/// Newton iterations after which a state counts as unsolved. Converged states of the demo need 34 iterations on average
/// and at most 81.
constexpr int max_iterations = 200;
/// Newton iterations of an increment of several tools, 34 / 4, over those of one tool, 23551 / 4883; of the demo.
constexpr double iterations_over_one_tool = 1.8;
/// The largest error of a state over the target; it limits rare errors that the 95th percentile misses.
constexpr double max_over_p95 = 3;
/// A mean that is large at the same 95th percentile is that of a body whose usual states are wrong.
constexpr double p95_over_mean = 2.5;
/// The error of three tools over that of two at the same target.
constexpr double triples_over_pairs = 2;

class RandomTools {
 public:
  explicit RandomTools(const DatabaseHeader& header)
      : _nodes(header.mesh.nodes),
        _normals(node_normals(header.mesh)),
        _touchable(touchable_nodes(header.mesh, header.sets, stored_scene(header).probe.tool_radius_m)),
        _directions(stored_scene(header).probe.directions),
        _depth_m(depth_fraction * header.magnitudes_m.back()) {}

  /// The ratio of the uniform density at these places to the sampling density, in which every second state is within a
  /// distance.
  double weight(const std::vector<phn_tool>& tools, double within_m) const {
    const auto is_near = [&](std::int32_t node) {
      return (_nodes.row(node) - _nodes.row(tools[0].nodes[0])).norm() <= within_m;
    };
    double n = static_cast<double>(_touchable.size()),
           near = static_cast<double>(std::ranges::count_if(_touchable, is_near));
    double density_ratio = 1;  // ratio of the density of near states to the uniform density
    for (std::size_t t = 1; t < tools.size(); ++t) {
      if (--near < 1) return 1;  // too few points are near, so that the places were uniform
      density_ratio *= is_near(tools[t].nodes[0]) ? --n / near : 0;
    }
    return 2 / (1 + density_ratio);
  }

  /// @param within_m  largest distance from the first tool, unless no such point is found
  /// @pre there are so many nodes
  std::vector<phn_tool> draw(const NodeList& nodes, std::size_t n_tools, double within_m,
                             std::mt19937_64& random) const {
    std::vector<phn_tool> tools;
    for (int attempt = 0; tools.size() < n_tools; ++attempt) {
      const auto node = random_element(nodes, random);
      if (std::ranges::any_of(tools, [&](const auto& tool) { return tool.nodes[0] == node; })) continue;
      const bool is_too_far = !tools.empty() && (_nodes.row(node) - _nodes.row(tools[0].nodes[0])).norm() > within_m;
      if (is_too_far && attempt < max_attempts) continue;
      const Eigen::Vector3d d =
          _depth_m * to_eigen(random_direction(random, _directions, _normals.row(node).transpose()));
      tools.push_back(tool_at(node, {d[0], d[1], d[2]}));
    }
    return tools;
  }

  const NodeList& touchable() const { return _touchable; }

 private:
  const Points& _nodes;
  Points _normals;
  NodeList _touchable;
  Directions _directions;
  double _depth_m;
};

/// @return whether all increments converged
bool solve(ProbeSolver& solver, SolvedTools& state) {
  std::vector<std::int32_t> nodes;
  std::vector<Vec3> d;
  for (const auto& tool : state.tools) {
    nodes.push_back(tool.nodes[0]);
    d.push_back({tool.displacement[0], tool.displacement[1], tool.displacement[2]});
  }
  std::vector<double> fractions;
  for (int i = 1; i <= increments; ++i) fractions.push_back(static_cast<double>(i) / increments);
  int iterations = 0;
  solver.set_stop([&] { return ++iterations > max_iterations; }, 0);
  try {
    solver.touch(nodes);
    solver.follow(d, fractions, false, [&](std::size_t, const Response& response) {
      if (response.status != Status::converged) return false;
      state.force_N = response.force_N;
      state.displacement_m.push_back(response.displacement_m);
      return true;
    });
  } catch (const Interrupted&) {
    return false;
  } catch (const Error&) {  // a tangent that is not factorized
    solver.recover();
  }
  return state.displacement_m.size() == fractions.size();
}

}  // namespace

double increments_of(const ToolDraws& draws) {
  return iterations_over_one_tool * increments * static_cast<double>(draws.pairs + draws.triples);
}

std::vector<SolvedTools> solve_several_tools(const SolverSession& session, const DatabaseHeader& header,
                                             const ToolDraws& draws, const OnProgress& progress) {
  OrderedRows<SolvedTools> rows;
  session.together([&] {
    const RandomTools random_tools(header);
    ProbeSolver solver(stored_scene(header), header.mesh, header.sets);
    const auto n = draws.pairs + draws.triples;
    distribute(session, n, progress, {}, [&](std::size_t turn) {
      const auto i = static_cast<std::size_t>(n) - 1 - turn;  // states of three tools, which take longest, come first
      const std::size_t n_tools = static_cast<std::int64_t>(i) < draws.pairs ? 2 : 3;
      if (header.sets.active.size() < n_tools) return;
      const double within_m = i % 2 == 1 && draws.half_within_m > 0 ? draws.half_within_m : HUGE_VAL;
      const bool at_probed = draws.half_at_probed && i % 4 < 2;
      std::mt19937_64 random(draws.seed * 1000003 + i);
      SolvedTools state;
      state.tools =
          random_tools.draw(at_probed ? header.sets.active : random_tools.touchable(), n_tools, within_m, random);
      if (draws.half_within_m > 0) state.weight = random_tools.weight(state.tools, draws.half_within_m);
      if (solve(solver, state)) rows.add({static_cast<double>(i)}, state);
    });
  });
  return rows.gathered(session);
}

Eigen::MatrixXd fields_of(const std::vector<SolvedTools>& solved) {
  Eigen::MatrixXd fields;
  Eigen::Index n = 0;
  for (const auto& state : solved)
    for (const auto& u : state.displacement_m) {
      if (n == 0) fields.resize(u.size(), std::ssize(solved) * increments);
      fields.col(n++) = u.reshaped();
    }
  return fields;
}

ErrorStatistics weighted_statistics(std::vector<std::pair<double, double>> errors) {
  ErrorStatistics s;
  s.n = std::ssize(errors);
  if (errors.empty()) return s;
  std::ranges::sort(errors);
  double all = 0, below = 0;
  for (const auto& [x, weight] : errors) all += weight;
  for (const auto& [x, weight] : errors) {
    s.mean += x * weight / all;
    for (auto [share, value] : {std::pair{0.5, &s.median}, {0.95, &s.p95}})
      if (const double rank = share * (1 - 1e-12) * all; below < rank && below + weight >= rank) *value = x;
    below += weight;
  }
  s.max = errors.back().first;
  return s;
}

ToolErrors tool_errors(const ReducedBody& body, const std::vector<SolvedTools>& solved, const OnProgress& progress) {
  const auto loaded = NamedOrgan::body(write_body_text(body), "body", max_steps);
  const auto place = [&](const phn_tool& tool) {
    return body.points.row(std::ranges::lower_bound(body.nodes, tool.nodes[0]) - body.nodes.begin());
  };
  const auto n_modes = static_cast<std::int32_t>(body.modes.entries.cols());
  std::vector<std::pair<double, double>> errors[2], near;
  ToolErrors out;
  std::int64_t steps = 0;
  const std::clock_t begin = std::clock();
  for (const auto& state : solved) {
    if (progress) progress(&state - solved.data() + 1, std::ssize(solved));
    if (schema::least_body_modes(static_cast<std::int32_t>(state.tools.size())) > n_modes) continue;
    OrganResponse response;
    loaded.organ().reset().ignore();
    for (int i = 1; i <= increments; ++i) {
      response = loaded.hold(tools_at({state.tools, {}}, static_cast<double>(i) / increments));
      steps += response.report.steps;
    }
    double largest = 0, largest_error = 0, smallest_distance_m = HUGE_VAL;
    for (std::size_t t = 0; t < state.tools.size(); ++t) {
      largest = std::max(largest, to_eigen(state.force_N[t]).norm());
      largest_error = std::max(largest_error, (to_eigen(*response.force_N[t]) - to_eigen(state.force_N[t])).norm());
      for (std::size_t s = 0; s < t; ++s)
        smallest_distance_m = std::min(smallest_distance_m, (place(state.tools[t]) - place(state.tools[s])).norm());
    }
    const bool is_near =
        smallest_distance_m < schema::near_part * body.tool_radius_m || (response.status & PHN_WARNING_NEAR) != 0;
    (is_near ? near : errors[state.tools.size() > 2]).emplace_back(largest_error / largest, state.weight);
    out.unsettled += (response.status & PHN_WARNING_UNSETTLED) != 0;
  }
  out.step_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC /
               static_cast<double>(std::max<std::int64_t>(1, steps));
  out.pairs = weighted_statistics(errors[0]);
  out.triples = weighted_statistics(errors[1]);
  out.near = weighted_statistics(near);
  return out;
}

Eigen::MatrixXd displacements_under(const ReducedBody& body, const std::vector<SolvedTools>& solved) {
  const auto loaded = NamedOrgan::body(write_body_text(body), "body", max_steps);
  Eigen::MatrixXd out(body.modes.rows(), 2 * std::ssize(solved));
  for (Eigen::Index s = 0; s < std::ssize(solved); ++s) {
    loaded.organ().reset().ignore();
    for (int i = 1; i <= increments; ++i) {
      const auto response =
          loaded.hold(tools_at({solved[static_cast<std::size_t>(s)].tools, {}}, static_cast<double>(i) / increments));
      if (2 * i % increments == 0)
        out.col(2 * s + 2 * i / increments - 1) = response.displacement_m.reshaped<Eigen::RowMajor>();
    }
  }
  return out;
}

double target_error(const ToolErrors& errors, int tools) {
  const double of_triples = tools > 2 ? errors.triples.p95 / triples_over_pairs : 0;
  return std::max({errors.pairs.p95, errors.pairs.max / max_over_p95, p95_over_mean * errors.pairs.mean, of_triples});
}

bool leave_out_at_rest(ReducedBody& body, ToolErrors& errors, const std::vector<SolvedTools>& solved, double target,
                       int tools, const OnProgress& progress) {
  if (target_error(errors, tools) <= target || body.cells_at_rest.entries.size() == 0) return false;
  ReducedBody other = body;
  other.cells_at_rest = other.lack_at_rest = {};
  const auto without = tool_errors(other, solved, progress);
  if (target_error(without, tools) >= required_improvement * target_error(errors, tools)) return false;
  body = std::move(other);
  errors = without;
  return true;
}

}  // namespace phynness
