#include <algorithm>
#include <chrono>
#include <cmath>
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

  std::int32_t nearest_corner() const {
    return nodes[static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin())];
  }
};

std::vector<Place> choose_places(const Scene& scene, const NamedOrgan& model, SurfacePart where, std::int64_t points,
                                 std::int64_t displacements, std::uint64_t seed) {
  const auto& surface = model.model().surface;
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
  const Points normals = node_normals(model.mesh());
  std::mt19937_64 random(seed);
  std::vector<Place> places(static_cast<std::size_t>(points));
  for (auto& place : places) {
    const auto t = triangles[static_cast<std::size_t>(uniform(random) * static_cast<double>(triangles.size()))];
    place.weights = point_of_triangle(random);
    for (int k = 0; k < 3; ++k) place.nodes[static_cast<std::size_t>(k)] = surface(t, k);
    const Eigen::Vector3d normal = normals.row(place.nearest_corner()).transpose();
    for (int attempt = 0; attempt < 1000 && std::ssize(place.displacements) < displacements; ++attempt) {
      const Vec3 e = on_sphere(random);
      if (scene.probe.directions == Directions::hemisphere && normal.dot(Eigen::Vector3d(e[0], e[1], e[2])) >= 0)
        continue;
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

  /// A place that the solver refuses counts as not solved.
  void try_at(std::size_t point, const Place& place, PointReport& report) {
    try {
      at(point, place, report);
    } catch (const Error& refused) {
      for (const auto& d : place.displacements) _rows.add({static_cast<double>(point)}, probe(point, place, d));
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
  /// Without errors, not solved.
  JudgedProbe probe(std::size_t point, const Place& place, const Vec3& d) const {
    JudgedProbe made;
    made.node = static_cast<std::int32_t>(point);
    made.displacement_m = d;
    made.flagged = is_flagged(_model.hold({tool_at(place, d)}).status);
    made.reached_m = -1;
    return made;
  }

  void at(std::size_t point, const Place& place, PointReport& report) {
    std::vector<Compared> coupled, linear, of_body;
    std::vector<JudgedProbe> probes;
    _solver.touch_points({place});
    for (const auto& d : place.displacements) {
      const auto truth = _solver.solve({d}, _increments);
      probes.push_back(probe(point, place, d));
      probes.back().status = truth.status;
      if (truth.status != Status::converged) {
        ++report.failed;
        continue;
      }
      const Points u = truth.displacement_m(_model.model().output, Eigen::all);
      const auto said = _model.hold({tool_at(place, d)});
      report.answers.take(said, truth.force_N);
      coupled.push_back({*said.force_N[0], truth.force_N[0], said.displacement_m, u});
      auto [linear_force, linear_u] = linear_response(_solver, _model.model(), {d});
      linear.push_back({*linear_force[0], truth.force_N[0], std::move(linear_u), u});
      if (!_body) continue;
      auto answer = _body->at({tool_at(place, d)});
      report.body_answers.take(answer, truth.force_N);
      of_body.push_back({*answer.force_N[0], truth.force_N[0], std::move(answer.displacement_m), _body->shared(u)});
    }
    judge(point, probes, coupled, linear);
    add_errors(coupled, {}, _coupled);
    add_errors(linear, {}, _linear);
    add_errors(of_body, {}, _of_body);
  }

  /// @param coupled, linear  of the solved probes
  void judge(std::size_t point, std::vector<JudgedProbe>& probes, const std::vector<Compared>& coupled,
             const std::vector<Compared>& linear) {
    LargestResponse largest;
    std::size_t at = 0;
    for (const auto& judged : probes)
      if (judged.solved()) largest.take(coupled[at].force_FE, coupled[at].u_FE, {}, judged.flagged), ++at;
    at = 0;
    for (auto& judged : probes) {
      if (judged.solved()) {
        judged.model = probe_errors(coupled[at], largest, {});
        judged.linear = probe_errors(linear[at], largest, {});
        ++at;
      }
      _rows.add({static_cast<double>(point)}, judged);
    }
  }

 public:
  void finish(const SolverSession& session, PointReport& report) const {
    static_cast<ErrorsByWarning&>(report) = errors_by_warning(_rows.gathered(session));
    report.coupled = statistics(session, _coupled);
    report.linear = statistics(session, _linear);
    if (_body) report.body = statistics(session, _of_body);
    add_ranks(session, {&report.finished, &report.failed}, report.answers);
    add_ranks(session, {}, report.body_answers);
  }

 private:
  PointSamples _coupled, _linear, _of_body;
  JudgedRows _rows;
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
  session.together([&] {
    const auto places = choose_places(scene, model, part, points, displacements, seed);
    report.points = std::ssize(places);
    comparison.emplace(scene, model, body, stop);
    report.finished = share_out(session, report.points, progress, stop,
                                [&](std::size_t i) { comparison->try_at(i, places[i], report); });
  });
  comparison->require_some(session, report.finished);
  comparison->finish(session, report);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
