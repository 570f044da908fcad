#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <phynness/formats/error.hpp>
#include <phynness/meshes/meshes.hpp>
#include <phynness/meshes/tool_weights.hpp>
#include <phynness/precompute/precompute.hpp>
#include <phynness/precompute/sample_rays.hpp>
#include <phynness/validation/discretization.hpp>
#include <phynness/validation/error_statistics.hpp>
#include <tuple>

#include "compared_scene.hpp"

namespace phynness {

namespace {

/// A direction of displacement of the tool at a point in space.
struct TradePlace {
  Vec3 point_m{}, direction{};
};

/// Ratios of the numbers of nodes to that of the scene's mesh.
std::vector<double> sizes_of(const Scene& scene) {
  const bool is_made = (scene.mesh.target_nodes || scene.mesh.target_size_m) && scene.mesh.thickness_m == 0;
  return is_made ? std::vector<double>{0.5, 1, 2} : std::vector<double>{1};
}

Scene resized(Scene scene, double factor) {
  if (auto& n = scene.mesh.target_nodes) n = static_cast<int>(std::lround(*n * factor));
  if (auto& h = scene.mesh.target_size_m) *h *= std::cbrt(1 / factor);
  return scene;
}

class Trade {
 public:
  Trade(const Scene& scene, const Mesh& mesh, const NodeSets& sets, const DiscretizationOptions& options,
        const OnProgress& progress, const ShouldStop& stop);
  TradeReport run();

 private:
  void add_rows(const Scene& sized, const Mesh& mesh, const NodeSets& sets, bool is_scene_mesh);
  void solve(TradeRow& row);
  void compare(TradeRow& row);
  /// @throws Error (input)
  void require_time_for(const TradeRow& reference) const;
  double elapsed() const { return _options.clock() - _start; }
  /// Expected time of all probes of a row.
  double expected_s(const TradeRow& row) const {
    return _scene_ray_s * std::pow(row.unknowns / _scene_unknowns, cost_exponent) * static_cast<double>(_places.size());
  }

  const DiscretizationOptions& _options;
  const OnProgress& _progress;
  const ShouldStop& _stop;
  double _start = _options.clock();
  std::vector<TradePlace> _places;
  std::vector<double> _depths;
  TradeReport _report;
  std::vector<std::vector<VariantForces>> _forces;  ///< per row and place
  std::size_t _reference = 0;
  double _scene_ray_s = 0, _scene_unknowns = 0;  ///< time of a probe of the scene itself
  std::int64_t _done = 0;
};

Trade::Trade(const Scene& scene, const Mesh& mesh, const NodeSets& sets, const DiscretizationOptions& options,
             const OnProgress& progress, const ShouldStop& stop)
    : _options(options), _progress(progress), _stop(stop) {
  const Scene common = compared_scene(scene, mesh, sets);
  _report.tool_radius_m = common.probe.tool_radius_m;
  const NodeSets answered{sets.fixed, answered_nodes(scene, mesh, sets), {}};
  const auto header = database_header(common, mesh, answered);
  _depths = header.magnitudes_m;
  const auto chosen = choose_checked_rays(header, requested_rays(common, mesh, header), _report.tool_radius_m,
                                          static_cast<std::size_t>(options.probes));
  for (const auto& ray : chosen.rays) {
    const Eigen::RowVector3d x = mesh.nodes.row(answered.active[static_cast<std::size_t>(ray.active)]);
    _places.push_back({{x[0], x[1], x[2]}, header.directions[static_cast<std::size_t>(ray.direction)]});
  }
  if (_places.empty())
    throw input_error("the scene has no rays", scene.source_name, "check nodes.active and the directions");
  _report.probes = std::ssize(_places);
  for (const double size : sizes_of(scene)) {
    const Scene sized = resized(common, size);
    if (size == 1) {
      add_rows(sized, mesh, sets, true);
      continue;
    }
    try {
      const auto made = make_mesh(sized);
      add_rows(sized, made.mesh, resolve_selections(sized, made.mesh), false);
    } catch (const Error& error) {
      TradeRow& row = _report.rows.emplace_back();
      row.scene = sized;
      const std::string message = error.what();
      row.left_out = message.substr(0, message.find('\n'));
    }
  }
  if (std::ranges::count_if(_report.rows, [](const TradeRow& row) { return row.body.has_value(); }) < 2)
    throw input_error("the scene has one element on one mesh, and nothing to trade", name(scene.solver.element),
                      "compare it with cells of half the size: --reference half-size");
  _forces.resize(_report.rows.size());
  const Element finest = element_named(finer_reference(scene) == Variant::taylor_hood ? "taylor-hood" : "P2");
  for (std::size_t i = 0; i < _report.rows.size(); ++i)
    if (_report.rows[i].body && _report.rows[i].scene.solver.element == finest) _reference = i;
  _report.rows[_reference].is_reference = true;
}

void Trade::add_rows(const Scene& sized, const Mesh& mesh, const NodeSets& sets, bool is_scene_mesh) {
  const double edges = static_cast<double>(mesh_edges(mesh).size());
  for (const auto& element : elements()) {
    if (element.is_shell != sized.solver.element->is_shell) continue;
    if (element.mixed && !(sized.material.lame_lambda_Pa > 0)) continue;
    TradeRow& row = _report.rows.emplace_back();
    row.scene = sized;
    row.scene.solver.element = &element;
    row.body = database_header(row.scene, mesh, sets);
    const auto requested = requested_rays(row.scene, mesh, *row.body);
    row.rays = std::count(requested.begin(), requested.end(), char{1});
    row.unknowns = unknowns_of(&element, mesh.n_nodes(), edges);
    row.is_scene = is_scene_mesh && sized.solver.element == &element;
    if (row.is_scene) _scene_unknowns = row.unknowns;
  }
}

void Trade::solve(TradeRow& row) {
  auto& all = _forces[static_cast<std::size_t>(&row - _report.rows.data())];
  const std::clock_t before = std::clock();
  ProbeSolver solver(row.scene, row.body->mesh, {row.body->sets.fixed, row.body->sets.active, row.body->sets.active});
  solver.set_stop(_stop);
  for (const auto& place : _places) {
    auto& forces = all.emplace_back();
    try {
      solver.touch_points({nearest_on_surface(row.body->mesh.nodes, row.body->mesh.surface, place.point_m)});
      solver.follow(
          {place.direction}, _depths, false,
          [&](std::size_t, const Response& response) {
            forces.status.push_back(response.status);
            forces.force_N.push_back(response.force_N.front());
            return true;
          },
          solver.limits_of_rays());
    } catch (const Interrupted&) {
      _report.interrupted = true;
      return;
    } catch (const Error&) {  // a place that cannot be touched on this mesh has no forces
      solver.recover();
    }
    if (_progress) _progress(++_done, std::ssize(_places) * std::ssize(_report.rows));
  }
  row.ray_s = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC / static_cast<double>(_places.size());
}

void Trade::compare(TradeRow& row) {
  const auto& own = _forces[static_cast<std::size_t>(&row - _report.rows.data())];
  const auto& finer = _forces[_reference];
  std::vector<double> errors;
  for (std::size_t p = 0; p < std::min(own.size(), finer.size()); ++p)
    if (const auto error = CheckedProbe{.own = own[p], .finer = finer[p]}.error()) errors.push_back(*error);
  const auto statistics = ErrorStatistics::of(errors);
  row.probes = row.is_reference || !(row.ray_s > 0) ? 0 : statistics.n;  // the time is 0 if the row was interrupted
  row.mean = statistics.mean;
  row.p95 = statistics.p95;
  if (row.probes == 0 && row.left_out.empty() && !row.is_reference && !_report.interrupted)
    row.left_out = "no probe was solved";
}

void Trade::require_time_for(const TradeRow& reference) const {
  const double expected = expected_s(reference);
  if (elapsed() + expected <= _options.seconds) return;
  throw input_error(
      "the finer solution needs more time than it may take",
      fmt::format("{} s are expected for {} probes of {} on {} nodes", std::lround(expected), _places.size(),
                  name(reference.scene.solver.element), reference.body->mesh.n_nodes()),
      fmt::format("give --seconds {}, fewer --probes, or a coarser mesh", std::lround(4 * expected + 60)));
}

TradeReport Trade::run() {
  auto& rows = _report.rows;
  const TradeRow& finest = rows[_reference];
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].body) order.push_back(i);
  // The first solve, of the scene, predicts the times of the others. Cheaper ones are next, then the required
  // reference.
  std::ranges::sort(order, {}, [&](std::size_t i) {
    const TradeRow& row = rows[i];
    const bool is_costly = row.unknowns > _scene_unknowns;
    return std::tuple(!row.is_scene, row.is_reference ? 1 : is_costly ? 2 : 0, row.unknowns);
  });
  for (const auto i : order) {
    if (_report.interrupted || (_stop && _stop())) break;
    TradeRow& row = rows[i];
    if (!row.is_scene && !row.is_reference) {
      const double expected = expected_s(row), reserved = finest.ray_s > 0 ? 0 : expected_s(finest);
      if (elapsed() + expected + reserved > _options.seconds) {
        row.left_out = fmt::format("time: about {} s", std::lround(expected));
        continue;
      }
    }
    solve(row);
    if (!row.is_scene) continue;
    _scene_ray_s = row.ray_s;
    if (!row.is_reference && !_report.interrupted) require_time_for(finest);
  }
  for (auto& row : rows) compare(row);
  for (auto& row : rows)
    row.on_front = row.probes > 0 && std::none_of(rows.begin(), rows.end(), [&](const TradeRow& other) {
                     return other.probes > 0 && other.mean <= row.mean && other.core_hours() <= row.core_hours() &&
                            (other.mean < row.mean || other.core_hours() < row.core_hours());
                   });
  _report.seconds = elapsed();
  return std::move(_report);
}

}  // namespace

bool is_alone(const TradeReport& report) {
  return std::ranges::all_of(report.rows, [](const TradeRow& row) { return row.probes == 0 || row.is_scene; });
}

const TradeRow* chosen_row(const TradeReport& report, double error) {
  if (is_alone(report)) return nullptr;
  const TradeRow* best = nullptr;
  for (const auto& row : report.rows)
    if (row.probes > 0 && row.mean <= error && (best == nullptr || row.core_hours() < best->core_hours())) best = &row;
  return best;
}

TradeReport compare_discretizations(const Scene& scene, const Mesh& mesh, const NodeSets& sets,
                                    const DiscretizationOptions& options, const OnProgress& progress,
                                    const ShouldStop& stop) {
  return Trade(scene, mesh, sets, options, progress, stop).run();
}

}  // namespace phynness
