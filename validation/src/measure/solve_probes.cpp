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
    for (const auto held : tool->prescribed) {
      const auto it = std::lower_bound(model.output.begin(), model.output.end(), held);
      if (it != model.output.end() && *it == held) counts[static_cast<std::size_t>(it - model.output.begin())] = 0;
    }
  }
  return counts;
}

namespace {

/// The fields of the model as the types of the solver.
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

/// Magnitudes at which a ray is solved: the trained increments up to the deepest probe, and the probes.
std::vector<double> waypoints(const ProbePair& pair, double increment_m) {
  std::vector<double> probes;
  for (const double depth : {pair.inside_m, pair.outside_m, pair.to_range_m, pair.beyond_range_m})
    if (depth > 0) probes.push_back(depth);
  std::sort(probes.begin(), probes.end());
  probes.erase(std::unique(probes.begin(), probes.end()), probes.end());
  std::vector<double> s = probes;
  for (int i = 1; i * increment_m < probes.back(); ++i) s.push_back(i * increment_m);
  std::sort(s.begin(), s.end());
  // A waypoint next to a probe would only add a solve.
  std::vector<double> kept;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const bool crowded = (i + 1 < s.size() && s[i + 1] - s[i] < 0.25 * increment_m) ||
                         (!kept.empty() && s[i] - kept.back() < 0.25 * increment_m);
    if (std::binary_search(probes.begin(), probes.end(), s[i]) || !crowded) kept.push_back(s[i]);
  }
  return kept;
}

/// The probes of one ray, in the order in which the solver reaches them.
class RayProbes {
 public:
  RayProbes(const Model& model, const ProbeSolver& solver, const ProbePair& pair, bool first, NodeProbes& found)
      : _model(model), _solver(solver), _pair(pair), _first(first), _found(found) {}

  /// @return whether the ray goes on
  bool take(double s, const Response& response) {
    if (response.status != Status::converged) {
      _end = response.status;
      return false;
    }
    ++_found.increments;
    _reached_m = s;
    const auto& e = _pair.direction;
    if (_first) {
      _found.curve.depth_m.push_back(s);
      _found.curve.force_N.push_back(response.force_N[0]);
    }
    const std::array<bool, 2> wanted{s == _pair.inside_m, s == _pair.outside_m};
    const bool in_range = s == _pair.to_range_m || s == _pair.beyond_range_m;
    if (!wanted[0] && !wanted[1] && !in_range) return true;
    auto state = state_of(_model, _solver, {s * e[0], s * e[1], s * e[2]}, response);
    const std::size_t list = wanted[0] ? 0 : wanted[1] ? 1 : 2;
    auto& states = list < 2 ? _found.states[list] : _found.further;
    if (in_range) {
      RangeProbe probe = range_probe(s);
      probe.status = Status::converged;
      probe.list = list;
      probe.at = states.size();
      _found.range.push_back(probe);
    }
    if (list < 2) _got[list] = true;
    states.push_back(std::move(state));
    return true;
  }

  /// Counts the probes that were not reached.
  void finish() {
    _found.failed += (_pair.inside_m > 0 && !_got[0]) + (_pair.outside_m > 0 && !_got[1]);
    for (const double s : {_pair.to_range_m, _pair.beyond_range_m})
      if (s > _reached_m) _found.range.push_back(range_probe(s));
  }

  /// No state can be solved.
  void refuse(Status why) {
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
  NodeProbes& _found;
  Status _end = Status::not_solved;
  double _reached_m = 0;
  std::array<bool, 2> _got{false, false};
};

/// Solves the probes of one node. `go_on` is called after every ray.
NodeProbes probe_node(const Model& model, ProbeSolver& solver, const NodePlan& entry, double increment_m,
                      const ShouldStop& go_on) {
  NodeProbes found;
  found.node = entry.node;
  try {
    solver.touch({entry.node});
  } catch (const Error& error) {
    if (error.kind() == Error::Kind::input) throw;
    for (const auto& pair : entry.pairs) {  // none can be solved; those of other nodes can
      RayProbes(model, solver, pair, false, found).refuse(Status::factorization);
      if (!go_on()) break;
    }
    return found;
  }
  found.counts = counted_nodes(model, {entry.node});
  if (!entry.pairs.empty()) found.curve = {entry.node, entry.pairs.front().direction, {}, {}};
  for (const auto& pair : entry.pairs) {
    const auto s = waypoints(pair, increment_m);
    RayProbes probes(model, solver, pair, &pair == &entry.pairs.front(), found);
    const std::clock_t cpu_start = std::clock();
    const std::size_t n_before = found.range.size();
    try {
      solver.follow({pair.direction}, s, false,
                    [&](std::size_t i, const Response& response) { return probes.take(s[i], response); });
    } catch (const Interrupted&) {
      found.range.resize(n_before);  // `range` has whole rays only, so that its depths stay uniform
      break;
    }
    found.cpu_s += static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
    probes.finish();
    if (!go_on()) break;
  }
  return found;
}

}  // namespace

std::int64_t solve_probes(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const std::vector<NodePlan>& plan, const OnProgress& progress, const ShouldStop& stop,
                          const std::function<void(std::size_t, NodeProbes&&)>& take) {
  // The physics hash does not depend on stored fields, so that the fields of the model are solved for in place of the
  // scene's.
  Scene with_fields = scene;
  with_fields.database.fields = fields_of(model.model());
  ProbeSolver solver(with_fields, model.mesh(), {model.model().fixed, {}, model.model().output});
  solver.set_stop(stop);
  std::int64_t solved = 0;
  bool stopped = false;
  std::int64_t rays = 0;
  for (const auto& entry : plan) rays += static_cast<std::int64_t>(entry.pairs.size());
  const auto stops = [&] { return stopped = stopped || (stop && stop()); };
  const auto go_on = [&] {
    ++solved;
    if (progress && session.rank() == 0) progress(std::min(rays, solved * session.size()), rays);
    return !stops();
  };
  share_out(session, static_cast<std::int64_t>(plan.size()), {}, stops, [&](std::size_t e) {
    take(e, probe_node(model.model(), solver, plan[e], scene.probe.max_displacement_m / scene.probe.increments, go_on));
  });
  return solved;
}

}  // namespace phynness
