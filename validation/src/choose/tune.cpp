#include <chrono>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/training/families.hpp>
#include <phynness/validation/probed_states.hpp>
#include <phynness/validation/tuning.hpp>

namespace phynness {
namespace {

/// Few nodes with many probes each, because (17) divides by the largest force of a node's probes, which needs many
/// probes.
constexpr std::int64_t nodes_per_try = 10;

}  // namespace

std::vector<Candidate> tuning_candidates(const Scene& scene) {
  std::vector<Candidate> all;
  for (const auto* family : every_family()) {
    if (schema::traits(family->family).proportional && !scene.material.law->linear) continue;
    for (const auto& spec : candidates(*family, scene.training)) all.push_back({family->model_name(spec), spec});
  }
  return all;
}

TuningReport tune(const SolverSession& session, const Scene& scene, const Database& database, std::int64_t probes,
                  std::uint64_t seed, const TuningProgress& progress) {
  const auto start = std::chrono::steady_clock::now();
  const auto& mesh = database.header().mesh;
  TuningReport report;
  report.probes = probes;
  std::vector<NodeProbes> solved;
  for (const auto& candidate : tuning_candidates(scene)) {
    MeasuredModel measured;
    measured.candidate = candidate;
    TrainingReport training;
    try {
      measured.model = train(database, candidate.spec, training, [&](std::int64_t done, std::int64_t total) {
        progress("train " + candidate.name, done, total);
      });
    } catch (const Error& error) {
      report.left_out.push_back(candidate.name + ": " + error.what());
      continue;
    }
    measured.candidate.name = operations(candidate.spec.family).model_name(sizes_of(measured.model));
    measured.model.title = scene.title;
    measured.training_s = training.seconds;
    const NamedOrgan model(measured.model, mesh, candidate.name);
    if (solved.empty()) {
      const auto plan = plan_probes(model, scene.probe.directions, probes, seed, nodes_per_try);
      solve_probes(
          session, scene, model, plan,
          [&](std::int64_t done, std::int64_t total) { progress("solve probes", done, total); }, {},
          [&](std::size_t, NodeProbes&& found) {
            report.nodes.push_back(found.node);
            report.failed += found.failed;
            solved.push_back(std::move(found));
          });
      report.linear = linear_errors(solved);
    }
    measured.errors = model_errors(model, solved);
    measured.speed = measure_speed(model);
    measured.memory_bytes = static_cast<double>(model.organ().constant_bytes());
    measured.text_bytes = static_cast<double>(model.text().size());
    report.models.push_back(std::move(measured));
  }
  if (report.models.empty())
    throw input_error("no candidate could be trained",
                      report.left_out.empty() ? "there is no candidate" : report.left_out.front(),
                      "check the database with `phynness info`");
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
