#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/probed_states.hpp>
#include <phynness/validation/tools.hpp>

#include "probe_records.hpp"
#include "shared_work.hpp"

namespace phynness {

namespace {

struct Pair {
  std::vector<std::int32_t> nodes;
  std::vector<Vec3> displacement_m;
};

/// Whether a tool itself moves the node that another one touches; those that move means may overlap.
bool moves(const ActiveNodeModel& tool, std::int32_t other) {
  return !tool.moves_mean && std::find(tool.prescribed.begin(), tool.prescribed.end(), other) != tool.prescribed.end();
}

std::vector<Pair> choose_pairs(const Scene& scene, const NamedOrgan& model, std::int64_t n, double depth_m,
                               std::uint64_t seed) {
  const auto& nodes = model.model().nodes;
  const Points normals = node_normals(model.mesh());
  std::mt19937_64 random(seed);
  const auto any_node = [&]() -> const ActiveNodeModel& {
    return nodes[static_cast<std::size_t>(uniform(random) * static_cast<double>(nodes.size()))];
  };
  std::vector<Pair> pairs(static_cast<std::size_t>(n));
  for (auto& pair : pairs) {
    bool apart = false;
    for (int attempt = 0; attempt < 10000 && !apart && nodes.size() > 1; ++attempt) {
      const auto &a = any_node(), &b = any_node();
      apart = a.node != b.node && !moves(a, b.node) && !moves(b, a.node);
      pair.nodes = {a.node, b.node};
    }
    if (!apart)
      throw input_error("the model has no two nodes that tools can touch at the same time",
                        std::to_string(nodes.size()) + " active nodes",
                        "make more nodes active or patches smaller, or omit --pairs");
    for (const auto node : pair.nodes) {
      Vec3 e = on_sphere(random);
      const Eigen::Vector3d normal = normals.row(node).transpose();
      while (scene.probe.directions == Directions::hemisphere && normal.dot(to_eigen(e)) >= 0) e = on_sphere(random);
      pair.displacement_m.push_back({depth_m * e[0], depth_m * e[1], depth_m * e[2]});
    }
  }
  return pairs;
}

/// Errors of an answer or of the linear predictor. @param counts  per output node: 0 if a tool itself moves it
ProbeErrors errors_of(const std::vector<std::optional<Vec3>>& force_N, const Points& u, const std::vector<Vec3>& truth,
                      const Points& u_FE, const std::vector<char>& counts) {
  ProbeErrors errors;
  const double sizes[2] = {to_eigen(truth[0]).norm(), to_eigen(truth[1]).norm()}, larger = std::max(sizes[0], sizes[1]);
  for (std::size_t t = 0; t < 2 && larger > 0; ++t) {
    const double off = (to_eigen(*force_N[t]) - to_eigen(truth[t])).norm();
    errors.force = std::max(errors.force, off / larger);
    errors.force_own = std::max(errors.force_own, off / std::max(sizes[t], force_floor * larger));
  }
  if (!(larger > 0)) errors.force = errors.force_own = std::numeric_limits<double>::quiet_NaN();
  LargestResponse largest;
  largest.take({}, u_FE, counts);
  const auto of_nodes = probe_errors({{}, {}, u, u_FE}, largest, counts).displacement;
  if (!of_nodes.empty()) errors.displacement = {ErrorStatistics::of(of_nodes).mean};
  return errors;
}

class PairComparison : public ToolComparison {
 public:
  using ToolComparison::ToolComparison;

  JudgedProbe at(std::size_t number, const Pair& pair, AnswerCounts& counts) {
    JudgedProbe judged;
    judged.node = static_cast<std::int32_t>(number);
    judged.displacement_m = pair.displacement_m[0];
    judged.reached_m = -1;
    try {
      _solver.touch(pair.nodes);
    } catch (const Error&) {
      judged.status = Status::factorization;
      return judged;
    }
    std::vector<phn_tool> tools;
    for (std::size_t t = 0; t < 2; ++t) tools.push_back(tool_at(at_node(pair.nodes[t]), pair.displacement_m[t]));
    judge(_body ? _body->at(tools) : _model.hold(tools), pair, judged, counts);
    return judged;
  }

 private:
  void judge(const OrganResponse& said, const Pair& pair, JudgedProbe& judged, AnswerCounts& answers) {
    judged.flagged = is_flagged(said.status);
    const auto truth = _solver.solve(pair.displacement_m, _increments);
    judged.status = truth.status;
    if (!judged.solved()) return;
    const Points u_FE = truth.displacement_m(_model.model().output, Eigen::all);
    const auto counts = counted_nodes(_model.model(), pair.nodes);
    judged.model = errors_of(said.force_N, said.displacement_m, truth.force_N, _body ? _body->shared(u_FE) : u_FE,
                             _body ? _body->shared(counts) : counts);
    const auto [linear_force, linear_u] = linear_response(_solver, _model.model(), pair.displacement_m);
    judged.linear = errors_of(linear_force, linear_u, truth.force_N, u_FE, counts);
    answers.take(said, truth.force_N);
  }
};

}  // namespace

PairReport validate_pairs(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          const NamedOrgan* body, std::int64_t pairs, double depth_m, std::uint64_t seed,
                          const OnProgress& progress, const ShouldStop& stop) {
  const auto start = std::chrono::steady_clock::now();
  PairReport report;
  report.pairs = pairs;
  report.depth_m = depth_m;
  report.by_body = body != nullptr;
  JudgedRows rows;  // in the order of the seed
  session.together([&] {
    if (model.has_round_tools() && !body)
      throw input_error("a model of round tools answers one tool", "--pairs", several_round_tools);
    const auto chosen = choose_pairs(scene, model, pairs, depth_m, seed);
    PairComparison comparison(scene, model, body, stop);
    report.finished = share_out(session, pairs, progress, stop, [&](std::size_t i) {
      rows.add({static_cast<double>(i)}, comparison.at(i, chosen[i], report.answers));
    });
  });
  static_cast<ErrorsByWarning&>(report) = errors_by_warning(rows.gathered(session));
  report.failed = std::ssize(report.unreached);
  add_ranks(session, {&report.finished}, report.answers);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
