#include <algorithm>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/probe_points.hpp>
#include <phynness/training/training.hpp>
#include <phynness/tuning/spacing.hpp>

namespace phynness {
namespace {

struct State {
  Vec3 displacement_m{}, force_N{};
};

/// The converged increments of a node of the database, and the size of the largest force.
std::vector<State> states_of(const Database& database, std::size_t active, double& largest_N) {
  std::vector<State> states;
  const auto& header = database.header();
  const Points displacements = prescribed_displacements(header);
  largest_N = 0;
  for (const Ray& ray : database.rays(static_cast<std::int32_t>(active)))
    for (std::size_t i = 0; i < ray.status.size(); ++i) {
      if (ray.status[i] != Status::converged) continue;
      State& state = states.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        state.displacement_m[k] =
            displacements(ray.direction * std::ssize(ray.status) + static_cast<Eigen::Index>(i), static_cast<int>(k));
        state.force_N[k] = ray.force[3 * i + k];
      }
      largest_N = std::max(largest_N, to_eigen(state.force_N).norm());
    }
  return states;
}

std::int32_t nearest(const Points& nodes, const std::vector<std::int32_t>& points, std::int32_t node) {
  return *std::min_element(points.begin(), points.end(), [&](auto a, auto b) {
    return (nodes.row(a) - nodes.row(node)).squaredNorm() < (nodes.row(b) - nodes.row(node)).squaredNorm();
  });
}

void compare(const Database& all, const LoadedModel& model, SpacingRow& row) {
  const auto& header = all.header();
  std::vector<std::int32_t> points;
  for (const auto& node : model.model().nodes) points.push_back(node.node);
  std::vector<double> between, at_nearest;
  for (std::size_t a = 0; a < header.sets.active.size(); ++a) {
    const auto node = header.sets.active[a];
    if (std::binary_search(points.begin(), points.end(), node)) continue;
    double largest = 0;
    const auto states = states_of(all, a, largest);
    if (states.empty() || !(largest > 0)) continue;
    ++row.left_out;
    const auto point = nearest(header.mesh.nodes, points, node);
    try {
      for (const auto& [d, f] : states) {
        const auto said = model.couple({tool_at(at_node(node), d)});
        between.push_back((to_eigen(*said.force_N[0]) - to_eigen(f)).norm() / largest);
        at_nearest.push_back((to_eigen(model.force(point, d)) - to_eigen(f)).norm() / largest);
      }
    } catch (const Error&) {
      ++row.unanswered;
    }
  }
  row.between = ErrorStatistics::of(std::move(between));
  row.nearest = ErrorStatistics::of(std::move(at_nearest));
}

}  // namespace

std::vector<SpacingRow> compare_spacings(const Scene& scene, const std::filesystem::path& file,
                                         const TuningProgress& progress) {
  if (scene.probe.kind != ProbeKind::patch)
    throw input_error("only round tools are answered between points", scene.probe.where.str(),
                      "set kind = \"patch\" and tool_radius_m, or omit --spacing");
  const Database all = Database::open(file);
  std::vector<SpacingRow> rows;
  for (const double part : {0.25, 1.0 / 3, 0.4, 0.5, 0.6, 0.8, 1.0}) {
    SpacingRow row;
    row.spacing_m = part * scene.probe.tool_radius_m;
    DatabaseHeader some = all.header();
    const auto& mirror = some.sets.mirror;
    some.sets.active = spread_nodes(some.mesh.nodes, some.mesh.surface, some.sets.active, row.spacing_m, 0,
                                    mirror ? mirror->image : NodeList{});
    row.points = std::ssize(some.sets.active);
    if (row.points == std::ssize(all.header().sets.active)) continue;
    if (row.points < 3 || (!rows.empty() && rows.back().points == row.points)) continue;
    const Database part_of_it = Database::open(file, some);
    auto source = responses_of(part_of_it);
    source.spreads = true;
    TrainingReport report;
    const std::string doing = "train " + std::to_string(row.points) + " points";
    Model model = train(source, scene.training, report, [&](std::int64_t done, std::int64_t total) {
      progress(doing, done, total);
      return true;
    });
    compare(all, LoadedModel(std::move(model), some.mesh, doing), row);
    rows.push_back(row);
  }
  if (rows.empty())
    throw input_error("no point can be left out", std::to_string(all.header().sets.active.size()) + " active nodes",
                      "probe more of them, or omit --spacing");
  return rows;
}

}  // namespace phynness
