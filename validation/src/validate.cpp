#include <algorithm>
#include <chrono>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/validation/probed_states.hpp>

#include "measures.hpp"
#include "packed.hpp"
#include "probe_records.hpp"
#include "range_records.hpp"

namespace phynness {
namespace {

constexpr std::size_t n_predictors = predictors.size();
enum Group : std::size_t { inside = 0, outside = 1 };

/// Normalized errors of one predictor.
struct GroupSamples : GroupMeasures<std::vector<double>> {
  std::vector<FieldMeasures<std::vector<double>>> fields;
};
using Samples = std::array<GroupSamples, 2>;  ///< by Group

Samples no_samples(std::size_t n_fields) {
  Samples samples;
  for (auto& group : samples) group.fields.resize(n_fields);
  return samples;
}

/// Prediction for a probe; `u` and `fields` are empty if the predictor has forces only.
struct Prediction {
  Vec3 force{};
  Points u;
  Eigen::MatrixXd fields;  ///< n_output x n_fields
};
using Predict = std::function<Prediction(std::int32_t node, const ProbedState&)>;

Predict by_model(const LoadedModel& model) {
  return [&model](std::int32_t node, const ProbedState& state) {
    auto said = model.respond({node}, {state.d});
    return Prediction{*said.force_N[0], std::move(said.displacement_m), std::move(said.fields)};
  };
}
Prediction by_linear(std::int32_t, const ProbedState& state) {
  return {state.force_linear, state.u_linear, state.fields_linear};
}
Prediction by_zero(std::int32_t, const ProbedState& state) {
  return {Vec3{}, Points::Zero(state.u_FE.rows(), 3),
          Eigen::MatrixXd::Zero(state.fields_FE.rows(), state.fields_FE.cols())};
}

double norm(const Vec3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
double distance(const Vec3& a, const Vec3& b) { return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

void check_same_scene(const Scene& scene, const LoadedModel& model) {
  const std::string& trained = model.model().physics_hash;
  if (physics_hash(scene) != trained && physics_hash(as_hashed(scene, trained)) == trained)
    throw input_error("the model is of this scene, solved with equations of an earlier version", "physics " + trained,
                      "precompute and train again");
  if (physics_hash(scene) != model.model().physics_hash)
    throw input_error("the model was trained for another scene",
                      "physics " + model.model().physics_hash + ", this scene's " + physics_hash(scene),
                      "validate with the scene of the model's database, or precompute and train again");
}

constexpr std::size_t max_examples = 5;

ForceExample example(const LoadedModel& model, std::int32_t node, const ProbedState& state) {
  return {node, state.d, state.force_FE, model.force(node, state.d), state.force_linear};
}

/// Normalized errors of fields. @param said  response of the predictor for each state
void collect_fields(const std::vector<ProbedState>& states, const std::vector<Eigen::MatrixXd>& said,
                    GroupSamples& samples) {
  const Eigen::Index n_fields = states.empty() ? 0 : states.front().fields_FE.cols();
  for (Eigen::Index f = 0; f < n_fields; ++f) {
    double largest = 0;
    for (const auto& state : states) largest = std::max(largest, state.fields_FE.col(f).cwiseAbs().maxCoeff());
    for (std::size_t s = 0; s < states.size(); ++s) {
      if (said[s].size() == 0) continue;  // the node has forces only
      const Eigen::VectorXd FE = states[s].fields_FE.col(f), error = said[s].col(f) - FE;
      auto& out = samples.fields[static_cast<std::size_t>(f)];
      for (Eigen::Index i = 0; largest > 0 && i < error.size(); ++i) out.nodal.push_back(std::abs(error[i]) / largest);
      if (FE.norm() > 0) out.l2.push_back(error.norm() / FE.norm());
    }
  }
}

/// Converts the probes of one active node and group to samples of (17).
void collect(const Predict& predict, const NodeProbes& probes, Group group, Samples& samples) {
  const auto& counts = probes.counts;
  auto& out = samples[group];
  double largest_force = 0, largest_u = 0;
  for (const auto& state : probes.states[group]) {
    largest_force = std::max(largest_force, norm(state.force_FE));
    for (Eigen::Index i = 0; i < state.u_FE.rows(); ++i)
      if (counts[static_cast<std::size_t>(i)]) largest_u = std::max(largest_u, state.u_FE.row(i).norm());
  }
  std::vector<Eigen::MatrixXd> fields_said;
  for (const auto& state : probes.states[group]) {
    std::vector<std::pair<double, Eigen::Index>> by_motion;
    for (Eigen::Index i = 0; i < state.u_FE.rows(); ++i)
      if (counts[static_cast<std::size_t>(i)]) by_motion.emplace_back(-state.u_FE.row(i).norm(), i);
    std::sort(by_motion.begin(), by_motion.end());
    const std::size_t n_moving = (by_motion.size() + 9) / 10;
    const Prediction said = predict(probes.node, state);
    fields_said.push_back(said.fields);
    const double force_error = distance(said.force, state.force_FE);
    if (largest_force > 0) out.force.push_back(force_error / largest_force);
    if (norm(state.force_FE) > 0) out.force_relative.push_back(force_error / norm(state.force_FE));
    if (said.u.rows() == 0) continue;
    double error2 = 0, norm2 = 0;
    for (std::size_t rank = 0; rank < by_motion.size(); ++rank) {
      const auto i = by_motion[rank].second;
      const double error = (said.u.row(i) - state.u_FE.row(i)).norm();
      if (largest_u > 0) out.displacement.push_back(error / largest_u);
      if (largest_u > 0 && rank < n_moving) out.displacement_moving.push_back(error / largest_u);
      error2 += error * error;
      norm2 += by_motion[rank].first * by_motion[rank].first;
    }
    if (norm2 > 0) out.field_l2.push_back(std::sqrt(error2 / norm2));
  }
  collect_fields(probes.states[group], fields_said, out);
}

/// The samples of all ranks, on rank 0. Collective.
void gather(const SolverSession& session, GroupSamples& samples) {
  const auto of_all = [&](const auto&, auto& list, const char* = nullptr) { list = session.gather(list); };
  GroupMeasures<std::vector<double>>::describe(samples, of_all);
  for (auto& field : samples.fields) FieldMeasures<std::vector<double>>::describe(field, of_all);
}

/// @param fields  of the model; empty: without their errors
PredictorErrors statistics(const Samples& samples, const std::vector<FieldModes>& fields = {}) {
  const auto of = [&](const GroupSamples& group) {
    GroupErrors errors{statistics(group), {}};
    for (std::size_t f = 0; f < fields.size(); ++f)
      errors.fields.emplace_back(fields[f].name, statistics(group.fields[f]));
    return errors;
  };
  return {of(samples[inside]), of(samples[outside])};
}

PredictorErrors errors_of(const Predict& predict, const std::vector<NodeProbes>& probes) {
  std::size_t n_fields = 0;
  for (const auto& node : probes)
    for (const auto& states : node.states)
      for (const auto& state : states) n_fields = std::max(n_fields, static_cast<std::size_t>(state.fields_FE.cols()));
  Samples samples = no_samples(n_fields);
  for (const auto& node : probes)
    for (const Group g : {inside, outside}) collect(predict, node, g, samples);
  return statistics(samples);
}

}  // namespace

PredictorErrors model_errors(const LoadedModel& model, const std::vector<NodeProbes>& probes) {
  return errors_of(by_model(model), probes);
}

PredictorErrors linear_errors(const std::vector<NodeProbes>& probes) { return errors_of(by_linear, probes); }

ValidationReport validate(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                          std::int64_t probes, std::uint64_t seed, const OnProgress& progress, const ShouldStop& stop,
                          std::int64_t nodes) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<NodePlan> plan;
  std::int64_t rays = 0;
  const std::array<Predict, n_predictors> predict{by_model(model), by_linear, by_zero};  // by Predictor
  std::array<Samples, n_predictors> samples;
  samples.fill(no_samples(model.model().fields.size()));
  std::vector<double> examples;
  std::array<std::vector<double>, 2> distances;  // by Group
  ProbeRecords records(model);
  RangeRecords range(model);
  double failed = 0, solved[2] = {0, 0}, increments = 0, cpu_s = 0;
  session.together([&] {
    check_same_scene(scene, model);
    plan = plan_probes(model, scene.probe.directions, probes, seed, nodes, scene.probe.max_displacement_m);
    rays = solve_probes(session, scene, model, plan, progress, stop, [&](std::size_t e, NodeProbes&& found) {
      for (const Group g : {inside, outside}) {
        for (std::size_t p = 0; p < n_predictors; ++p) collect(predict[p], found, g, samples[p]);
        // Only for errors of forces: a node without any force has none.
        for (const auto& state : found.states[g])
          if (distances[g].size() < samples[0][g].force.size())
            distances[g].push_back(model.trained_distance(found.node, state.d));
        solved[g] += static_cast<double>(found.states[g].size());
      }
      records.add(found);
      range.add(e, plan[e].weight, found);
      failed += static_cast<double>(found.failed);
      increments += static_cast<double>(found.increments);
      cpu_s += found.cpu_s;
      if (e < max_examples && !found.states[inside].empty())
        pack(examples, example(model, found.node, found.states[inside].front()));
    });
  });

  ValidationReport report;
  report.probes = probes;
  for (const auto& entry : plan) report.rays += static_cast<std::int64_t>(entry.pairs.size());
  report.rays_finished = static_cast<std::int64_t>(session.sum(static_cast<double>(rays)));
  report.failed = static_cast<std::int64_t>(session.sum(failed));
  report.solved_inside = static_cast<std::int64_t>(session.sum(solved[inside]));
  report.solved_outside = static_cast<std::int64_t>(session.sum(solved[outside]));
  report.outside_factor = outside_factor;
  for (const auto& entry : plan) {
    report.nodes.push_back(entry.node);
    report.fixed_distance_m.push_back(entry.fixed_distance_m);
  }
  for (std::size_t p = 0; p < n_predictors; ++p) {
    for (auto& group : samples[p]) gather(session, group);
    report.errors[p] = statistics(samples[p], model.model().fields);
  }
  for (const Group g : {inside, outside}) {
    const auto correlation = rank_correlation(session.gather(distances[g]), samples[0][g].force);
    (g == inside ? report.distance_correlation_inside : report.distance_correlation_outside) = correlation;
  }
  report.examples = unpacked<ForceExample>(session.gather(examples));
  std::sort(report.examples.begin(), report.examples.end(),
            [](const auto& a, const auto& b) { return a.node < b.node; });
  records.finish(session, report);
  report.to_range = errors_to_range(range.gathered(session), scene.probe.max_displacement_m);
  if (session.rank() == 0) report.speed = measure_speed(model);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.solve_ms_per_increment = 1e3 * session.sum(cpu_s) / std::max(1.0, session.sum(increments));
  return report;
}

}  // namespace phynness
