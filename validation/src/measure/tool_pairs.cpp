#include <algorithm>
#include <chrono>
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
  std::vector<SurfacePoint> places;
  std::vector<Vec3> displacement_m;
};

/// Whether a tool at a node prescribes the displacement of a node that another tool touches. Round tools may overlap.
bool prescribes(const Model& model, std::int32_t node, std::int32_t other) {
  const auto& tool = *std::ranges::find(model.nodes, node, &ActiveNodeModel::node);
  return !tool.moves_mean && std::ranges::find(tool.prescribed, other) != tool.prescribed.end();
}

/// On a body wherever it answers without a warning, on a model of node probes at its nodes.
std::vector<Pair> choose_pairs(const Scene& scene, const NamedOrgan& model, const NamedOrgan* body, std::int64_t n,
                               double depth_m, std::uint64_t seed) {
  const auto places = body ? RandomPlaces::answered(model, body) : RandomPlaces(model, {});
  std::mt19937_64 random(seed);
  std::vector<Pair> pairs(static_cast<std::size_t>(n));
  for (auto& pair : pairs) {
    bool is_valid = false;
    for (int attempt = 0; attempt < 10000 && !is_valid && model.model().nodes.size() > 1; ++attempt) {
      pair.places = {places.draw(random), places.draw(random)};
      const auto a = pair.places[0].nodes[0], b = pair.places[1].nodes[0];
      is_valid = places.at_nodes() ? a != b && !prescribes(model.model(), a, b) && !prescribes(model.model(), b, a)
                                   : pair.places[0].point != pair.places[1].point;
    }
    if (!is_valid)
      throw input_error("the model has no two nodes that tools can touch at the same time",
                        std::to_string(model.model().nodes.size()) + " active nodes",
                        "make more nodes active or patches smaller, or omit --pairs");
    for (const auto& place : pair.places) {
      const Vec3 e = places.draw_direction(random, scene.probe.directions, place);
      pair.displacement_m.push_back({depth_m * e[0], depth_m * e[1], depth_m * e[2]});
    }
  }
  return pairs;
}

/// Errors of an answer or of the linear predictor. @param counts  counted_nodes()
ProbeErrors errors_of(const std::vector<std::optional<Vec3>>& force_N, const Points& displacement,
                      const std::vector<Vec3>& solved_force_N, const Points& u_FE, const std::vector<char>& counts) {
  ProbeErrors errors;
  const double sizes[2] = {to_eigen(solved_force_N[0]).norm(), to_eigen(solved_force_N[1]).norm()},
               larger = std::max(sizes[0], sizes[1]);
  for (std::size_t t = 0; t < 2 && larger > 0; ++t) {
    const double error = (to_eigen(*force_N[t]) - to_eigen(solved_force_N[t])).norm();
    errors.force = std::max(errors.force, error / larger);
    errors.force_own = std::max(errors.force_own, error / std::max(sizes[t], force_floor * larger));
  }
  if (!(larger > 0)) errors.force = errors.force_own = std::numeric_limits<double>::quiet_NaN();
  LargestResponse largest;
  largest.add({}, u_FE, counts);
  const auto of_nodes = probe_errors({{}, {}, displacement, u_FE}, largest, counts).displacement;
  if (!of_nodes.empty()) errors.displacement = {ErrorStatistics::of(of_nodes).mean};
  return errors;
}

class PairComparison : public ToolComparison {
 public:
  using ToolComparison::ToolComparison;

  ProbeResult at(std::size_t number, const Pair& pair, AnswerCounts& counts) {
    ProbeResult result;
    result.node = static_cast<std::int32_t>(number);
    result.displacement_m = pair.displacement_m[0];
    result.reached_m = -1;
    try {
      _solver.touch_points(pair.places);
    } catch (const Error&) {
      result.status = Status::factorization;
      return result;
    }
    std::vector<phn_tool> tools;
    for (std::size_t t = 0; t < 2; ++t) tools.push_back(tool_at(pair.places[t], pair.displacement_m[t]));
    evaluate(_body ? _body->at(tools) : _model.hold(tools), pair, result, counts);
    return result;
  }

 private:
  void evaluate(const OrganResponse& response, const Pair& pair, ProbeResult& result, AnswerCounts& answers) {
    result.flagged = is_flagged(response.status);
    const auto solution = _solver.solve(pair.displacement_m, _increments);
    result.status = solution.status;
    if (!result.solved()) return;
    const Points u_FE = solution.displacement_m(_model.model().output, Eigen::all);
    std::vector<std::int32_t> touched;
    for (const auto& place : pair.places)
      if (place.weights[0] == 1) touched.push_back(place.nodes[0]);
    const auto counts = counted_nodes(_model.model(), touched);
    result.model = errors_of(response.force_N, response.displacement_m, solution.force_N,
                             _body ? _body->common_rows(u_FE) : u_FE, _body ? _body->common_rows(counts) : counts);
    const auto [linear_force, linear_u] = linear_response(_solver, _model.model(), pair.displacement_m);
    result.linear = errors_of(linear_force, linear_u, solution.force_N, u_FE, counts);
    answers.add(response, solution.force_N);
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
  ProbeResultRows rows;  // in the order of the seed
  session.together([&] {
    if (model.has_round_tools() && !body)
      throw input_error("a model of round tools answers one tool", "--pairs", several_round_tools);
    const auto chosen = choose_pairs(scene, model, body, pairs, depth_m, seed);
    PairComparison comparison(scene, model, body, stop);
    report.finished = distribute(session, pairs, progress, stop, [&](std::size_t i) {
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
