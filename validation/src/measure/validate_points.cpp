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

/// The nearest corner, or, if it only lies between active nodes, the active node nearest to the point.
std::int32_t nearest_active(const LoadedModel& model, const Place& place) {
  const auto active = model.runtime().active_nodes();
  const auto corner = place.nearest_corner();
  if (std::binary_search(active.begin(), active.end(), corner)) return corner;
  const Points& nodes = model.mesh().nodes;
  Eigen::RowVector3d x = Eigen::RowVector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) x += place.weights[k] * nodes.row(place.nodes[k]);
  return *std::min_element(active.begin(), active.end(), [&](auto a, auto b) {
    return (nodes.row(a) - x).squaredNorm() < (nodes.row(b) - x).squaredNorm();
  });
}

std::vector<Place> choose_places(const Scene& scene, const LoadedModel& model, std::int64_t points,
                                 std::int64_t displacements, std::uint64_t seed) {
  const auto& surface = model.model().surface;
  const auto triangles = answered_triangles(model);
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

  /// A place that the solver refuses counts as not solved, with the reason of the first one.
  void try_at(std::size_t point, const Place& place, PointReport& report) {
    try {
      at(point, place, report);
    } catch (const Error& refused) {
      for (const auto& d : place.displacements) _rows.add({static_cast<double>(point)}, probe(point, place, d));
      report.failed += std::ssize(place.displacements);
      report.refused += std::ssize(place.displacements);
      ++_refused;
      if (!_first_refusal) _first_refusal = refused;
      _solver.recover();
    }
  }

  /// @throws Error if every place was refused. Collective.
  void require_some(const SolverSession& session, std::int64_t finished) const {
    const double refused = session.sum(static_cast<double>(_refused)), all = session.sum(static_cast<double>(finished));
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
    made.flagged = is_flagged(_model.couple({tool_at(place, d)}).status);
    made.reached_m = -1;
    return made;
  }

  void at(std::size_t point, const Place& place, PointReport& report) {
    std::vector<Compared> coupled, linear, at_node, of_body;
    std::vector<JudgedProbe> probes;
    PointRecord record{place.nodes, place.weights};
    _solver.touch_points({place});
    for (const auto& d : place.displacements) {
      const auto truth = _solver.solve({d}, _increments);
      probes.push_back(probe(point, place, d));
      probes.back().status = truth.status;
      if (truth.status != Status::converged) {
        ++report.failed;
        continue;
      }
      const auto& output = _model.model().output;
      const Points u = truth.displacement_m(output, Eigen::all);
      const auto said = _model.couple({tool_at(place, d)});
      report.unsettled += (said.status & PHN_WARNING_UNSETTLED) != 0;
      report.largest_residual_m = std::max(report.largest_residual_m, said.coupled.residual);
      record.flagged[1] += probes.back().flagged;
      coupled.push_back({*said.force_N[0], truth.force_N[0], said.displacement_m, u});
      auto [linear_force, linear_u] = linear_response(_solver, _model.model(), {d});
      linear.push_back({*linear_force[0], truth.force_N[0], std::move(linear_u), u});
      if (!_body) continue;
      auto answer = _body->at({tool_at(place, d)});
      const auto [bounded, below] = covered(answer, truth.force_N);
      report.body_warnings->take(answer.status, bounded, below);
      record.flagged[2] += is_flagged(answer.status);
      of_body.push_back({answer.force_N[0], truth.force_N[0], std::move(answer.displacement_m), _body->shared(u)});
    }
    const auto corner = nearest_active(_model, place);
    _solver.touch({corner});
    for (const auto& d : place.displacements) {
      const auto truth = _solver.solve({d}, _increments);
      if (truth.status != Status::converged) continue;
      const auto said = _model.respond({corner}, {d});
      at_node.push_back({*said.force_N[0], truth.force_N[0], said.displacement_m,
                         truth.displacement_m(_model.model().output, Eigen::all)});
    }
    const auto largest = judge(point, probes, coupled, linear);
    const auto mean = [&](const std::vector<Compared>& compared) {
      double sum = 0;
      for (const auto& one : compared) sum += probe_errors(one, largest, {}).force;
      return sum / static_cast<double>(compared.size());
    };
    record.error = {mean(linear), mean(coupled), mean(of_body)};
    _records.add({static_cast<double>(point)}, record);
    add_errors(coupled, {}, _coupled);
    add_errors(linear, {}, _linear);
    add_errors(of_body, {}, _of_body);
    const auto& output = _model.model().output;
    std::vector<char> counts(output.size() + 1, 1);
    counts[static_cast<std::size_t>(std::lower_bound(output.begin(), output.end(), corner) - output.begin())] = 0;
    add_errors(at_node, counts, _at_nodes);
  }

  /// @param coupled, linear  of the solved probes
  LargestResponse judge(std::size_t point, std::vector<JudgedProbe>& probes, const std::vector<Compared>& coupled,
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
    return largest;
  }

 public:
  void finish(const SolverSession& session, double range_m, PointReport& report) const {
    report.to_range = errors_to_range(_rows.gathered(session), range_m, "points");
    report.records = _records.gathered(session);
    const auto errors_of = [&](const PointSamples& samples) {
      const auto errors = statistics(session, samples);
      return PointErrors{errors.force, errors.displacement, errors.field_l2};
    };
    report.coupled = errors_of(_coupled);
    report.linear = errors_of(_linear);
    report.at_nodes = errors_of(_at_nodes);
    if (_body) report.body = errors_of(_of_body);
    std::vector counts{&report.finished, &report.failed, &report.refused, &report.unsettled};
    if (_body) {
      auto& of_body = *report.body_warnings;
      counts.insert(counts.end(), {&of_body.unsettled, &of_body.outside, &of_body.bounded, &of_body.covered});
    }
    for (auto* count : counts) *count = static_cast<std::int64_t>(session.sum(static_cast<double>(*count)));
    report.first_refusal = refusal_of_any_rank(session);
    for (const double r : session.gather({report.largest_residual_m}))
      report.largest_residual_m = std::max(report.largest_residual_m, r);
  }

 private:
  /// The first that any rank has, without the remedy; on rank 0.
  std::string refusal_of_any_rank(const SolverSession& session) const {
    std::string own = _first_refusal ? std::string(_first_refusal->what()) : "";
    own = own.substr(0, own.find("\n  remedy: "));
    std::vector<double> rows;
    if (!own.empty()) pack(rows, own);
    const auto all = unpacked<std::string>(session.gather(rows));
    return all.empty() ? "" : all.front();
  }

  PointSamples _coupled, _linear, _at_nodes, _of_body;
  JudgedRows _rows;
  OrderedRows<PointRecord> _records;
  std::int64_t _refused = 0;
  std::optional<Error> _first_refusal;
};

}  // namespace

PointReport validate_points(const SolverSession& session, const Scene& scene, const LoadedModel& model,
                            LoadedBody* body, std::int64_t points, std::int64_t displacements, std::uint64_t seed,
                            const OnProgress& progress, const ShouldStop& stop) {
  const auto start = std::chrono::steady_clock::now();
  PointReport report;
  report.points = points;
  report.displacements = displacements;
  if (body) report.body_warnings.emplace();
  std::optional<PointComparison> comparison;
  session.together([&] {
    const auto places = choose_places(scene, model, points, displacements, seed);
    comparison.emplace(scene, model, body, stop);
    report.finished =
        share_out(session, points, progress, stop, [&](std::size_t i) { comparison->try_at(i, places[i], report); });
  });
  comparison->require_some(session, report.finished);
  comparison->finish(session, scene.probe.max_displacement_m, report);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace phynness
