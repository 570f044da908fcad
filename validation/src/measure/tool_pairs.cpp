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

const char* name(PairPredictor p) {
  return std::array{"coupled", "alone", "paper", "linear", "body"}[static_cast<std::size_t>(p)];
}

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();

/// Whether a tool itself moves the node that another one touches; those that move means may overlap.
bool moves(const ActiveNodeModel& tool, std::int32_t other) {
  return !tool.moves_mean && std::find(tool.prescribed.begin(), tool.prescribed.end(), other) != tool.prescribed.end();
}

std::vector<PairRecord> choose_pairs(const Scene& scene, const LoadedModel& model, std::int64_t pairs, double depth_m,
                                     std::uint64_t seed) {
  const auto& nodes = model.model().nodes;
  const Points normals = node_normals(model.mesh());
  std::mt19937_64 random(seed);
  const auto any_node = [&]() -> const ActiveNodeModel& {
    return nodes[static_cast<std::size_t>(uniform(random) * static_cast<double>(nodes.size()))];
  };
  std::vector<PairRecord> records(static_cast<std::size_t>(pairs));
  for (auto& record : records) {
    bool apart = false;
    for (int attempt = 0; attempt < 10000 && !apart && nodes.size() > 1; ++attempt) {
      const auto &a = any_node(), &b = any_node();
      apart = a.node != b.node && !moves(a, b.node) && !moves(b, a.node);
      record.nodes = {a.node, b.node};
    }
    if (!apart)
      throw input_error("the model has no two nodes that tools can touch at the same time",
                        std::to_string(nodes.size()) + " active nodes",
                        "make more nodes active or patches smaller, or omit --pairs");
    record.distance_m = (model.mesh().nodes.row(record.nodes[0]) - model.mesh().nodes.row(record.nodes[1])).norm();
    for (std::size_t t = 0; t < 2; ++t) {
      Vec3 e = on_sphere(random);
      const Eigen::Vector3d normal = normals.row(record.nodes[t]).transpose();
      while (scene.probe.directions == Directions::hemisphere && normal.dot(to_eigen(e)) >= 0) e = on_sphere(random);
      record.displacement_m[t] = {depth_m * e[0], depth_m * e[1], depth_m * e[2]};
    }
  }
  return records;
}

/// Errors of one prediction. @param counts  per output node: 0 if a tool itself moves it
PairErrors errors_of(const std::vector<std::optional<Vec3>>& force, const Points& u, const Response& truth,
                     const Points& u_FE, const std::vector<char>& counts) {
  PairErrors errors;
  const double sizes[2] = {to_eigen(truth.force_N[0]).norm(), to_eigen(truth.force_N[1]).norm()};
  const double larger = std::max(sizes[0], sizes[1]);
  for (std::size_t t = 0; t < 2; ++t) {
    const double off = force[t] ? (to_eigen(*force[t]) - to_eigen(truth.force_N[t])).norm() : none;
    errors.force = force[t] && larger > 0 ? std::max(errors.force, off / larger) : none;
    errors.force_own = force[t] && sizes[t] > 0 ? std::max(errors.force_own, off / sizes[t]) : none;
    errors.force_floored =
        force[t] && larger > 0 ? std::max(errors.force_floored, off / std::max(sizes[t], force_floor * larger)) : none;
  }
  const auto mean = [](const std::vector<double>& samples) {
    return samples.empty() ? none : ErrorStatistics::of(samples).mean;
  };
  GroupMeasures<std::vector<double>> counted, all;
  add_errors({{{}, {}, u, u_FE}}, counts, counted);
  add_errors({{{}, {}, u, u_FE}}, {}, all);
  errors.displacement = mean(counted.displacement);
  errors.field_l2 = mean(counted.field_l2);
  errors.displacement_all = mean(all.displacement);
  return errors;
}

class PairComparison : public ToolComparison {
 public:
  using ToolComparison::ToolComparison;

  void at(PairRecord& pair) {
    const std::vector<std::int32_t> nodes(pair.nodes.begin(), pair.nodes.end());
    const std::vector<Vec3> d(pair.displacement_m.begin(), pair.displacement_m.end());
    try {
      _solver.touch(nodes);
    } catch (const Error&) {
      pair.ended = Status::factorization;
      return;  // counts as not solved
    }
    std::vector<phn_tool> tools;
    for (std::size_t t = 0; t < 2; ++t) tools.push_back(tool_at(at_node(nodes[t]), d[t]));
    std::optional<ModelResponse> coupled;
    std::optional<BodyResponse> of_body;
    if (!_model.has_round_tools()) coupled = _model.couple(tools);
    if (_body) of_body = _body->at(tools);
    pair.has_nodes = coupled.has_value();
    pair.has_body = of_body.has_value();
    if (of_body) pair.status = pair.body_status = of_body->status;
    if (coupled) pair.status = coupled->status;
    const auto truth = _solver.solve(d, _increments);
    pair.ended = truth.status;
    pair.solved = truth.status == Status::converged;
    if (!pair.solved) return;
    const auto& output = _model.model().output;
    const auto counts = counted_nodes(_model.model(), nodes);
    const Points u_FE = truth.displacement_m(output, Eigen::all);
    using Forces = std::vector<std::optional<Vec3>>;
    const auto judge = [&](PairPredictor p, const Forces& force, const Points& u) {
      pair.errors[static_cast<std::size_t>(p)] = errors_of(force, u, truth, u_FE, counts);
    };

    const auto first = _model.respond({nodes[0]}, {d[0]}), second = _model.respond({nodes[1]}, {d[1]});
    judge(PairPredictor::alone, {first.force_N[0], second.force_N[0]}, first.displacement_m + second.displacement_m);
    if (coupled) {
      pair.residual_m = coupled->coupled.residual;
      judge(PairPredictor::coupled, coupled->force_N, coupled->displacement_m);
      judge(PairPredictor::paper, {std::nullopt, std::nullopt}, _model.respond(nodes, d).displacement_m);
    }

    const auto [linear_force, linear_u] = linear_response(_solver, _model.model(), d);
    judge(PairPredictor::linear, linear_force, linear_u);
    if (of_body) std::tie(pair.body_bounded, pair.body_covered) = covered(*of_body, truth.force_N);
    if (of_body)
      pair.errors[static_cast<std::size_t>(PairPredictor::body)] =
          errors_of(Forces(of_body->force_N.begin(), of_body->force_N.end()), of_body->displacement_m, truth,
                    _body->shared(u_FE), _body->shared(counts));
    pair.single_force =
        std::max(single_force(nodes[0], d[0], *first.force_N[0]), single_force(nodes[1], d[1], *second.force_N[0]));
  }

 private:
  /// Error of a tool alone, over its finite element force; infinite if this force is not known.
  double single_force(std::int32_t node, const Vec3& d, const Vec3& force) {
    _solver.touch({node});
    const Response truth = _solver.solve({d}, _increments);
    if (truth.status != Status::converged) return infinite;
    return (to_eigen(force) - to_eigen(truth.force_N[0])).norm() / to_eigen(truth.force_N[0]).norm();
  }
};

PairGroup group_of(const std::vector<PairRecord>& records, const std::function<bool(const PairRecord&)>& belongs) {
  PairGroup group;
  for (const auto& pair : records) {
    group.pairs += pair.solved && belongs(pair);
    group.has_nodes = group.has_nodes || pair.has_nodes;
    group.has_body = group.has_body || pair.has_body;
  }
  for (const auto p : pair_predictors) {
    if (!group.has(p)) continue;
    PairMeasures<std::vector<double>> samples;
    for (const auto& pair : records)
      if (pair.solved && belongs(pair))
        member_by_member(samples, pair.of(p), [](auto& list, double error) {
          if (!std::isnan(error)) list.push_back(error);
        });
    group.errors[static_cast<std::size_t>(p)] = statistics(samples);
  }
  return group;
}

ProbeErrors of_worse_tool(const PairErrors& errors) {
  ProbeErrors out{errors.force, errors.force_floored, {}};
  if (!std::isnan(errors.displacement)) out.displacement = {errors.displacement};
  return out;
}

/// @param by  coupled or body
std::vector<JudgedProbe> judged_pairs(const std::vector<PairRecord>& records, PairPredictor by) {
  std::vector<JudgedProbe> probes;
  for (const auto& pair : records) {
    JudgedProbe& made = probes.emplace_back();
    made.node = static_cast<std::int32_t>(probes.size() - 1);
    made.displacement_m = pair.displacement_m[0];
    made.flagged = is_flagged(by == PairPredictor::body ? pair.body_status : pair.status);
    made.status = pair.ended;
    made.reached_m = -1;
    made.model = of_worse_tool(pair.of(by));
    made.linear = of_worse_tool(pair.of(PairPredictor::linear));
  }
  return probes;
}

}  // namespace

PairReport validate_pairs(const SolverSession& session, const Scene& scene, const LoadedModel& model, LoadedBody* body,
                          std::int64_t pairs, double depth_m, std::uint64_t seed, const OnProgress& progress,
                          const ShouldStop& stop) {
  const auto start = std::chrono::steady_clock::now();
  PairReport report;
  report.pairs = pairs;
  report.depth_m = depth_m;
  const Points& x = model.mesh().nodes;
  report.far_m = far_fraction * (x.colwise().maxCoeff() - x.colwise().minCoeff()).maxCoeff();
  OrderedRows<PairRecord> rows;  // in the order of the seed
  std::int64_t finished = 0;
  session.together([&] {
    if (model.has_round_tools() && !body)
      throw input_error("a model of round tools answers one tool", "--pairs", several_round_tools);
    auto chosen = choose_pairs(scene, model, pairs, depth_m, seed);
    PairComparison comparison(scene, model, body, stop);
    finished = share_out(session, pairs, progress, stop, [&](std::size_t i) {
      comparison.at(chosen[i]);
      rows.add({static_cast<double>(i)}, chosen[i]);
    });
  });
  report.records = rows.gathered(session);
  report.finished = static_cast<std::int64_t>(session.sum(static_cast<double>(finished)));
  for (const auto& pair : report.records) {
    report.failed += !pair.solved;
    report.unsettled += pair.solved && (pair.status & PHN_WARNING_UNSETTLED) != 0;
    report.outside += pair.solved && (pair.status & PHN_WARNING_OUTSIDE) != 0;
    report.largest_residual_m = std::max(report.largest_residual_m, pair.residual_m);
  }
  report.all = group_of(report.records, [](const PairRecord&) { return true; });
  report.near = group_of(report.records, [&](const PairRecord& p) { return p.distance_m <= report.far_m; });
  report.far = group_of(report.records, [&](const PairRecord& p) { return p.distance_m > report.far_m; });
  report.unflagged = group_of(report.records, [](const PairRecord& p) { return !is_flagged(p.status); });
  report.right = group_of(report.records, [](const PairRecord& p) { return p.single_force <= right_alone; });
  if (!model.has_round_tools())
    report.by_warning = errors_by_warning(judged_pairs(report.records, PairPredictor::coupled));
  if (body) {
    report.body_warnings.emplace();
    for (const auto& pair : report.records)
      if (pair.solved) report.body_warnings->take(pair.body_status, pair.body_bounded, pair.body_covered);
    report.body_by_warning = errors_by_warning(judged_pairs(report.records, PairPredictor::body));
  }
  std::vector<double> alone;
  for (const auto& pair : report.records) {
    if (pair.solved && std::isfinite(pair.single_force)) alone.push_back(pair.single_force);
  }
  report.single_force = ErrorStatistics::of(std::move(alone));
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
