#include <algorithm>
#include <ctime>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/validation/probed_states.hpp>

#include "probe_records.hpp"
#include "shared_work.hpp"

namespace phynness {

std::vector<char> counted_nodes(const Model& model, const std::vector<std::int32_t>& touched) {
  std::vector<char> counts(model.output.size(), 1);
  for (const auto node : touched) {
    const auto tool = std::lower_bound(model.nodes.begin(), model.nodes.end(), node,
                                       [](const ActiveNodeModel& active, std::int32_t n) { return active.node < n; });
    if (tool == model.nodes.end() || tool->node != node || tool->moves_mean) continue;
    for (const auto prescribed : tool->prescribed) {
      const auto position = std::lower_bound(model.output.begin(), model.output.end(), prescribed);
      if (position != model.output.end() && *position == prescribed)
        counts[static_cast<std::size_t>(position - model.output.begin())] = 0;
    }
  }
  return counts;
}

namespace {

/// The fields of the model as types of the solver.
std::vector<Field> fields_of(const Model& model) {
  std::vector<Field> fields;
  for (const auto& of_model : model.fields) {
    const auto field = field_named(of_model.name);
    if (!field || (!fields.empty() && *field <= fields.back()))
      throw input_error("the model has a field that this version cannot compute", of_model.name,
                        "validate it with the version of phynness that trained it");
    fields.push_back(*field);
  }
  return fields;
}

ProbedState state_of(const Model& model, const ProbeSolver& solver, const Vec3& d, const Response& response) {
  const auto& output = model.output;
  ProbedState state;
  state.d = d;
  state.force_FE = response.force_N[0];
  state.u_FE = response.displacement_m(output, Eigen::all);
  auto linear = linear_response(solver, model, {d});
  state.force_linear = *linear.first[0];
  state.u_linear = std::move(linear.second);
  if (model.fields.empty()) return state;
  state.fields_FE = response.fields(output, Eigen::all);
  state.fields_linear = solver.linear_fields({d})(output, Eigen::all);
  return state;
}

/// The depths at which a ray is solved: the trained increments up to the deepest probe, and the probes.
std::vector<double> waypoints(const ProbePair& pair, double increment_m) {
  std::vector<double> probes;
  for (const double depth : {pair.inside_m, pair.outside_m, pair.to_range_m, pair.beyond_range_m})
    if (depth > 0) probes.push_back(depth);
  std::sort(probes.begin(), probes.end());
  probes.erase(std::unique(probes.begin(), probes.end()), probes.end());
  std::vector<double> s = probes;
  for (int i = 1; i * increment_m < probes.back(); ++i) s.push_back(i * increment_m);
  std::sort(s.begin(), s.end());
  // A waypoint that is near a probe is unnecessary.
  std::vector<double> result;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const bool is_crowded = (i + 1 < s.size() && s[i + 1] - s[i] < 0.25 * increment_m) ||
                            (!result.empty() && s[i] - result.back() < 0.25 * increment_m);
    if (std::binary_search(probes.begin(), probes.end(), s[i]) || !is_crowded) result.push_back(s[i]);
  }
  return result;
}

/// The probes of one ray, in the order in which the solver reaches them.
class RayProbes {
 public:
  RayProbes(const Model& model, const ProbeSolver& solver, const ProbePair& pair, bool first, NodeProbes& result)
      : _model(model), _solver(solver), _pair(pair), _first(first), _result(result) {}

  /// @return whether the ray continues
  bool add_state(double s, const Response& response) {
    if (response.status != Status::converged) {
      _end = response.status;
      return false;
    }
    ++_result.increments;
    _reached_m = s;
    const auto& e = _pair.direction;
    if (_first) {
      _result.curve.depth_m.push_back(s);
      _result.curve.force_N.push_back(response.force_N[0]);
    }
    const std::array<bool, 2> wanted{s == _pair.inside_m, s == _pair.outside_m};
    const bool in_range = s == _pair.to_range_m || s == _pair.beyond_range_m;
    if (!wanted[0] && !wanted[1] && !in_range) return true;
    auto state = state_of(_model, _solver, {s * e[0], s * e[1], s * e[2]}, response);
    const std::size_t list = wanted[0] ? 0 : wanted[1] ? 1 : 2;
    auto& states = list < 2 ? _result.states[list] : _result.further;
    if (in_range) {
      RangeProbe probe = range_probe(s);
      probe.status = Status::converged;
      probe.list = list;
      probe.at = states.size();
      _result.range.push_back(probe);
    }
    if (list < 2) _is_reached[list] = true;
    states.push_back(std::move(state));
    return true;
  }

  /// Counts the probes that were not reached.
  void finish() {
    _result.failed += (_pair.inside_m > 0 && !_is_reached[0]) + (_pair.outside_m > 0 && !_is_reached[1]);
    for (const double s : {_pair.to_range_m, _pair.beyond_range_m})
      if (s > _reached_m) _result.range.push_back(range_probe(s));
  }

  /// Marks all probes as unsolved.
  void mark_unsolvable(Status why) {
    _end = why;
    finish();
  }

 private:
  RangeProbe range_probe(double s) const {
    const auto& e = _pair.direction;
    RangeProbe probe;
    probe.d = {s * e[0], s * e[1], s * e[2]};
    probe.beyond = s == _pair.beyond_range_m;
    probe.status = _end;
    probe.reached_m = _reached_m;
    return probe;
  }

  const Model& _model;
  const ProbeSolver& _solver;
  const ProbePair& _pair;
  bool _first;
  NodeProbes& _result;
  Status _end = Status::not_solved;
  double _reached_m = 0;
  std::array<bool, 2> _is_reached{false, false};
};

/// Solves the probes of one node. @param on_ray  is called after every ray and returns whether the next one is solved.
NodeProbes probe_node(const Model& model, ProbeSolver& solver, const NodePlan& entry, double increment_m,
                      const ShouldStop& on_ray) {
  NodeProbes result;
  result.node = entry.node;
  try {
    solver.touch({entry.node});
  } catch (const Error& error) {
    if (error.kind() == Error::Kind::input) throw;
    for (const auto& pair : entry.pairs) {  // other nodes may be solved
      RayProbes(model, solver, pair, false, result).mark_unsolvable(Status::factorization);
      if (!on_ray()) break;
    }
    return result;
  }
  result.counts = counted_nodes(model, {entry.node});
  if (!entry.pairs.empty()) result.curve = {entry.node, entry.pairs.front().direction, {}, {}};
  for (const auto& pair : entry.pairs) {
    const auto s = waypoints(pair, increment_m);
    RayProbes probes(model, solver, pair, &pair == &entry.pairs.front(), result);
    const std::clock_t cpu_start = std::clock();
    const std::size_t n_before = result.range.size();
    try {
      solver.follow({pair.direction}, s, false,
                    [&](std::size_t i, const Response& response) { return probes.add_state(s[i], response); });
    } catch (const Interrupted&) {
      result.range.resize(n_before);  // `range` has complete rays only, so that its depths remain uniform
      break;
    }
    result.cpu_s += static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    probes.finish();
    if (!on_ray()) break;
  }
  return result;
}

}  // namespace

std::int64_t solve_probes(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const std::vector<NodePlan>& plan, const OnProgress& progress, const ShouldStop& stop,
                          const std::function<void(std::size_t, NodeProbes&&)>& on_node) {
  // The fields of the model replace those of the scene, on which the physics hash does not depend.
  Scene with_fields = scene;
  with_fields.database.fields = fields_of(model.model());
  ProbeSolver solver(with_fields, model.mesh(), {model.model().fixed, {}, model.model().output});
  solver.set_stop(stop);
  std::int64_t solved = 0;
  bool is_stopped = false;
  std::int64_t rays = 0;
  for (const auto& entry : plan) rays += static_cast<std::int64_t>(entry.pairs.size());
  const auto must_stop = [&] { return is_stopped = is_stopped || (stop && stop()); };
  const auto on_ray = [&] {
    ++solved;
    if (progress && session.rank() == 0) progress(std::min(rays, solved * session.size()), rays);
    return !must_stop();
  };
  distribute(session, static_cast<std::int64_t>(plan.size()), {}, must_stop, [&](std::size_t e) {
    on_node(
        e, probe_node(model.model(), solver, plan[e], scene.probe.max_displacement_m / scene.probe.increments, on_ray));
  });
  return solved;
}

}  // namespace phynness
