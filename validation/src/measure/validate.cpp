#include <algorithm>
#include <chrono>
#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/validation/probed_states.hpp>

#include "probe_records.hpp"

namespace phynness {
namespace {

constexpr std::size_t n_predictors = predictors.size();
enum Group : std::size_t { inside = 0, outside = 1 };

/// Normalized errors of one predictor.
struct GroupSamples : GroupMeasures<std::vector<double>> {
  std::vector<FieldMeasures<std::vector<double>>> fields;
};
using Samples = std::array<GroupSamples, 2>;  ///< by Group

/// The prediction for a probe; `u` and `fields` are empty for a predictor of forces only.
struct Prediction {
  Vec3 force{};
  Points u;
  Eigen::MatrixXd fields;  ///< n_output x n_fields
};
using Predict = std::function<Prediction(std::int32_t node, const ProbedState&)>;

Predict by_model(const NamedOrgan& model) {
  return [&model](std::int32_t node, const ProbedState& state) {
    auto response = model.blend({node}, {state.d});
    return Prediction{*response.force_N[0], std::move(response.displacement_m), std::move(response.fields)};
  };
}
Prediction by_linear(std::int32_t, const ProbedState& state) {
  return {state.force_linear, state.u_linear, state.fields_linear};
}
Prediction by_zero(std::int32_t, const ProbedState& state) {
  return {Vec3{}, Points::Zero(state.u_FE.rows(), 3),
          Eigen::MatrixXd::Zero(state.fields_FE.rows(), state.fields_FE.cols())};
}

void check_same_scene(const Scene& scene, const NamedOrgan& model) {
  if (physics_hash(scene) != model.model().physics_hash)
    throw input_error("the model was trained for another scene",
                      "physics " + model.model().physics_hash + ", this scene's " + physics_hash(scene),
                      "validate with the scene of the model's database, or precompute and train again");
}

/// Appends normalized errors of fields. @param predicted  fields of the predictor for each state
void collect_fields(const std::vector<ProbedState>& states, const std::vector<Eigen::MatrixXd>& predicted,
                    GroupSamples& samples) {
  const Eigen::Index n_fields = states.empty() ? 0 : states.front().fields_FE.cols();
  samples.fields.resize(std::max(samples.fields.size(), static_cast<std::size_t>(n_fields)));
  for (Eigen::Index f = 0; f < n_fields; ++f) {
    double largest = 0;
    for (const auto& state : states) largest = std::max(largest, state.fields_FE.col(f).cwiseAbs().maxCoeff());
    for (std::size_t s = 0; s < states.size(); ++s) {
      if (predicted[s].size() == 0) continue;  // the node has forces only
      const Eigen::VectorXd FE = states[s].fields_FE.col(f), error = predicted[s].col(f) - FE;
      auto& out = samples.fields[static_cast<std::size_t>(f)];
      for (Eigen::Index i = 0; largest > 0 && i < error.size(); ++i) out.nodal.push_back(std::abs(error[i]) / largest);
      if (FE.norm() > 0) out.l2.push_back(error.norm() / FE.norm());
    }
  }
}

/// Appends the errors (17) of the probes of one active node and group to the samples.
void collect(const Predict& predict, const NodeProbes& probes, Group group, Samples& samples) {
  std::vector<ComparedState> compared;
  std::vector<Eigen::MatrixXd> predicted_fields;
  for (const auto& state : probes.states[group]) {
    auto response = predict(probes.node, state);
    compared.push_back({response.force, state.force_FE, std::move(response.u), state.u_FE});
    predicted_fields.push_back(std::move(response.fields));
  }
  add_errors(compared, probes.counts, samples[group]);
  collect_fields(probes.states[group], predicted_fields, samples[group]);
}

/// The samples of all ranks, on rank 0. Collective.
void gather(const SolverSession& session, GroupSamples& samples) {
  const auto gather_list = [&](const auto&, auto& list, const char* = nullptr) { list = session.gather(list); };
  GroupMeasures<std::vector<double>>::describe(samples, gather_list);
  for (auto& field : samples.fields) FieldMeasures<std::vector<double>>::describe(field, gather_list);
}

/// @param fields  fields of the model; empty to omit their errors
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
  Samples samples;
  for (const auto& node : probes)
    for (const Group g : {inside, outside}) collect(predict, node, g, samples);
  return statistics(samples);
}

}  // namespace

PredictorErrors model_errors(const NamedOrgan& model, const std::vector<NodeProbes>& probes) {
  return errors_of(by_model(model), probes);
}

PredictorErrors linear_errors(const std::vector<NodeProbes>& probes) { return errors_of(by_linear, probes); }

ValidationReport validate(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                          std::int64_t probes, std::uint64_t seed, const OnProgress& progress, const ShouldStop& stop,
                          std::int64_t nodes) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<NodePlan> plan;
  std::int64_t rays = 0;
  const std::array<Predict, n_predictors> predict{by_model(model), by_linear, by_zero};  // by Predictor
  std::array<Samples, n_predictors> samples;
  for (auto& of_predictor : samples)  // the same on every rank
    for (auto& group : of_predictor) group.fields.resize(model.model().fields.size());
  ProbeRecords records(model);
  std::int64_t failed = 0, solved[2] = {0, 0}, increments = 0;
  double cpu_s = 0;
  session.together([&] {
    check_same_scene(scene, model);
    plan = plan_probes(model, scene.probe.directions, probes, seed, nodes, scene.probe.max_displacement_m);
    rays = solve_probes(session, scene, model, plan, progress, stop, [&](std::size_t e, NodeProbes&& found) {
      for (const Group g : {inside, outside}) {
        for (std::size_t p = 0; p < n_predictors; ++p) collect(predict[p], found, g, samples[p]);
        solved[g] += std::ssize(found.states[g]);
      }
      records.add(e, plan[e].weight, found);
      failed += found.failed;
      increments += found.increments;
      cpu_s += found.cpu_s;
    });
  });

  ValidationReport report;
  report.probes = probes;
  report.rays_finished = session.total(rays);
  report.failed = session.total(failed);
  report.solved_inside = session.total(solved[inside]);
  report.solved_outside = session.total(solved[outside]);
  report.outside_factor = outside_factor;
  for (const auto& entry : plan) {
    report.rays += std::ssize(entry.pairs);
    report.nodes.push_back(entry.node);
    report.fixed_distance_m.push_back(entry.fixed_distance_m);
  }
  for (std::size_t p = 0; p < n_predictors; ++p) {
    for (auto& group : samples[p]) gather(session, group);
    report.errors[p] = statistics(samples[p], model.model().fields);
  }
  records.finish(session, scene.probe.max_displacement_m, report);
  if (session.rank() == 0) report.speed = measure_speed(model);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  report.solve_ms_per_increment =
      1e3 * session.sum(cpu_s) / std::max(1.0, static_cast<double>(session.total(increments)));
  return report;
}

}  // namespace phynness
