#include <chrono>
#include <phynness/formats/error.hpp>
#include <phynness/precompute/probe_solver.hpp>
#include <phynness/validation/probe_plan.hpp>
#include <phynness/validation/tools.hpp>
#include <random>

#include "probe_records.hpp"
#include "shared_work.hpp"

namespace phynness {
namespace {

struct Place : SurfacePoint {
  std::vector<Vec3> displacements;
};

std::vector<Place> choose_places(const Scene& scene, const NamedOrgan& model, SurfacePart where, std::int64_t points,
                                 std::int64_t displacements, std::uint64_t seed) {
  auto by_corners = triangles_by_corners(model);
  auto& triangles = by_corners[where == SurfacePart::rim ? 2 : 3];
  if (where == SurfacePart::rim) {
    triangles.insert(triangles.end(), by_corners[1].begin(), by_corners[1].end());
    if (triangles.empty()) return {};
  }
  if (triangles.empty())
    throw input_error("no triangle of the surface has three active corners, or corners between active nodes",
                      std::to_string(model.model().nodes.size()) + " active nodes",
                      "probe a coherent part of the surface, or omit --points");
  const RandomPlaces random_places(model, model.model().surface(triangles, Eigen::all));
  std::mt19937_64 random(seed);
  std::vector<Place> places(static_cast<std::size_t>(points));
  for (auto& place : places) {
    static_cast<SurfacePoint&>(place) = random_places.draw(random);
    while (std::ssize(place.displacements) < displacements) {
      const Vec3 e = random_places.draw_direction(random, scene.probe.directions, place);
      const double d = scene.probe.max_displacement_m * (1 - uniform(random));
      place.displacements.push_back({d * e[0], d * e[1], d * e[2]});
    }
  }
  return places;
}

using PointSamples = GroupMeasures<std::vector<double>>;

class PointComparison : public ToolComparison {
 public:
  using ToolComparison::ToolComparison;

  /// Evaluates a place. A place that the solver refuses counts as unsolved.
  void evaluate_or_refuse(std::size_t point, const Place& place, PointReport& report) {
    try {
      evaluate(point, place, report);
    } catch (const Error& refused) {
      for (const auto& d : place.displacements) _results.add({static_cast<double>(point)}, probe(point, place, d));
      report.failed += std::ssize(place.displacements);
      ++_refused;
      if (!_first_refusal) _first_refusal = refused;
      _solver.recover();
    }
  }

  /// @throws Error if every place was refused. Collective.
  void require_some(const SolverSession& session, std::int64_t finished) const {
    const auto refused = session.total(_refused), all = session.total(finished);
    session.together([&] {
      if (refused > 0 && refused == all && _first_refusal) throw Error(*_first_refusal);
    });
  }

 private:
  /// The result of an unsolved probe.
  ProbeResult probe(std::size_t point, const Place& place, const Vec3& d) const {
    ProbeResult result;
    result.node = static_cast<std::int32_t>(point);
    result.displacement_m = d;
    result.flagged = is_flagged(_model.hold({tool_at(place, d)}).status);
    result.reached_m = -1;
    return result;
  }

  void evaluate(std::size_t point, const Place& place, PointReport& report) {
    std::vector<ComparedState> coupled, linear, of_body;
    std::vector<ProbeResult> probes;
    _solver.touch_points({place});
    for (const auto& d : place.displacements) {
      const auto solution = _solver.solve({d}, _increments);
      probes.push_back(probe(point, place, d));
      probes.back().status = solution.status;
      if (solution.status != Status::converged) {
        ++report.failed;
        continue;
      }
      const Points u = solution.displacement_m(_model.model().output, Eigen::all);
      const auto response = _model.hold({tool_at(place, d)});
      report.answers.add(response, solution.force_N);
      coupled.push_back({*response.force_N[0], solution.force_N[0], response.displacement_m, u});
      auto [linear_force, linear_u] = linear_response(_solver, _model.model(), {d});
      linear.push_back({*linear_force[0], solution.force_N[0], std::move(linear_u), u});
      if (!_body) continue;
      auto answer = _body->at({tool_at(place, d)});
      report.body_answers.add(answer, solution.force_N);
      of_body.push_back(
          {*answer.force_N[0], solution.force_N[0], std::move(answer.displacement_m), _body->common_rows(u)});
    }
    add_errors_of_probes(point, probes, coupled, linear);
    add_errors(coupled, {}, _model_samples);
    add_errors(linear, {}, _linear_samples);
    add_errors(of_body, {}, _body_samples);
  }

  /// @param coupled, linear  predictions for the solved probes
  void add_errors_of_probes(std::size_t point, std::vector<ProbeResult>& probes,
                            const std::vector<ComparedState>& coupled, const std::vector<ComparedState>& linear) {
    LargestResponse largest;
    std::size_t next = 0;
    for (const auto& result : probes)
      if (result.solved()) largest.add(coupled[next].force_FE, coupled[next].u_FE, {}, result.flagged), ++next;
    next = 0;
    for (auto& result : probes) {
      if (result.solved()) {
        result.model = probe_errors(coupled[next], largest, {});
        result.linear = probe_errors(linear[next], largest, {});
        ++next;
      }
      _results.add({static_cast<double>(point)}, result);
    }
  }

 public:
  void finish(const SolverSession& session, const std::vector<Place>& places, PointReport& report) const {
    const auto results = _results.gathered(session);
    static_cast<ErrorsByWarning&>(report) = errors_by_warning(results);
    for (const auto& result : results)
      if (result.solved() && result.model.force > (report.worst ? report.worst->error : -1))
        report.worst = {places[static_cast<std::size_t>(result.node)].point, result.model.force};
    report.coupled = statistics(session, _model_samples);
    report.linear = statistics(session, _linear_samples);
    if (_body) report.body = statistics(session, _body_samples);
    add_ranks(session, {&report.finished, &report.failed}, report.answers);
    add_ranks(session, {}, report.body_answers);
  }

 private:
  PointSamples _model_samples, _linear_samples, _body_samples;
  ProbeResultRows _results;
  std::int64_t _refused = 0;
  std::optional<Error> _first_refusal;
};

}  // namespace

PointReport validate_points(const SolverSession& session, const Scene& scene, const NamedOrgan& model,
                            const NamedOrgan* body, SurfacePart part, std::int64_t points, std::int64_t displacements,
                            std::uint64_t seed, const OnProgress& progress, const ShouldStop& stop) {
  const auto start = std::chrono::steady_clock::now();
  PointReport report;
  report.displacements = displacements;
  std::optional<PointComparison> comparison;
  std::vector<Place> places;
  session.together([&] {
    places = choose_places(scene, model, part, points, displacements, seed);
    report.points = std::ssize(places);
    comparison.emplace(scene, model, body, stop);
    report.finished = distribute(session, report.points, progress, stop,
                                 [&](std::size_t i) { comparison->evaluate_or_refuse(i, places[i], report); });
  });
  comparison->require_some(session, report.finished);
  comparison->finish(session, places, report);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
