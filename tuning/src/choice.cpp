#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <phynness/evaluation/loaded_model.hpp>
#include <phynness/formats/error.hpp>
#include <phynness/formats/probe_points.hpp>
#include <phynness/training/training.hpp>
#include <phynness/tuning/tuning.hpp>

namespace phynness {
namespace {

using Costs = std::array<double, 3>;

Costs costs(const MeasuredModel& m, ErrorStatistic statistic) {
  return {m.error(statistic), m.speed.deformation_us, m.memory_bytes};
}

struct StatisticRow {
  double ErrorStatistics::*value;
  const char* name;
};
/// In the order of the enum.
constexpr StatisticRow statistics[] = {{&ErrorStatistics::mean, "mean error"},
                                       {&ErrorStatistics::median, "median error"},
                                       {&ErrorStatistics::p95, "95 % quantile of the error"}};
const StatisticRow& row_of(ErrorStatistic statistic) { return statistics[static_cast<std::size_t>(statistic)]; }

std::string text(std::size_t what, double value) {
  return what == 0   ? fmt::format("{:.3g} %", 100 * value)
         : what == 1 ? fmt::format("{:.3g} us", value)
                     : fmt::format("{:.3g} MB", value / 1e6);
}

std::string describe_miss(const std::vector<MeasuredModel>& models, const Costs& limit, ErrorStatistic statistic) {
  const std::array<const char*, 3> what_of{row_of(statistic).name, "time of a deformation", "memory"};
  if (std::ranges::none_of(models, [&](const auto& m) { return std::isfinite(m.error(statistic)); }))
    return "no probe inside the trained range was solved, so that the errors are unknown";
  std::string said;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto best = std::ranges::min_element(models, {}, [&](const auto& m) { return costs(m, statistic)[k]; });
    const double least = costs(*best, statistic)[k];
    if (least > limit[k])
      said += fmt::format("{}{}: the smallest is {} ({}), {:.3g} times the limit of {}", said.empty() ? "" : "; ",
                          what_of[k], text(k, least), best->candidate.name, least / limit[k], text(k, limit[k]));
  }
  if (!said.empty()) return said;
  // Each limit can be met by some model. The model with the smallest factor above its limits is reported.
  const auto nearest = std::ranges::min_element(models, {}, [&](const MeasuredModel& m) {
    double ratio = 0;
    for (std::size_t k = 0; k < 3; ++k) ratio = std::max(ratio, costs(m, statistic)[k] / limit[k]);
    return ratio;
  });
  for (std::size_t k = 0; k < 3; ++k)
    if (const double cost = costs(*nearest, statistic)[k]; cost > limit[k])
      said += fmt::format("{} {} {}, limit {}", said.empty() ? "" : ";", what_of[k], text(k, cost), text(k, limit[k]));
  return fmt::format("each limit can be met, but not all of them by the same model; the nearest model is {}:{}",
                     nearest->candidate.name, said);
}

}  // namespace

double MeasuredModel::error(ErrorStatistic statistic) const {
  if (errors.inside.force.n == 0) return std::numeric_limits<double>::infinity();
  const auto value = row_of(statistic).value;
  return std::max(errors.inside.force.*value, errors.inside.displacement.*value);
}

void mark_front(std::vector<MeasuredModel>& models, ErrorStatistic statistic) {
  for (auto& m : models) {
    m.on_front = std::none_of(models.begin(), models.end(), [&](const MeasuredModel& other) {
      const auto a = costs(other, statistic), b = costs(m, statistic);
      return a != b && a[0] <= b[0] && a[1] <= b[1] && a[2] <= b[2];
    });
  }
}

TuningChoice choose_model(const std::vector<MeasuredModel>& models, const TuningLimits& limits) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const Costs limit{limits.error.value_or(none), limits.deformation_us.value_or(none),
                    limits.memory_bytes.value_or(none)};
  TuningChoice choice;
  const auto key = [&](const MeasuredModel& m) {
    const auto c = costs(m, limits.statistic);
    return limits.error ? std::array<double, 2>{c[1], c[2]} : std::array<double, 2>{c[0], c[1]};
  };
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto c = costs(models[i], limits.statistic);
    if (!std::isfinite(c[0])) continue;
    if (!(c[0] <= limit[0] && c[1] <= limit[1] && c[2] <= limit[2])) continue;
    if (!choice.chosen || key(models[i]) < key(models[*choice.chosen])) choice.chosen = i;
  }
  if (!choice.chosen) choice.missed = describe_miss(models, limit, limits.statistic);
  return choice;
}

const SpacingRow* sparsest(const std::vector<SpacingRow>& rows, double error, ErrorStatistic statistic) {
  const auto value = row_of(statistic).value;
  const SpacingRow* best = nullptr;
  for (const auto& row : rows) {
    // Where few points leave most of the surface without an answer, those that are left prove nothing.
    const bool answers = static_cast<double>(row.unanswered) <= 0.05 * static_cast<double>(row.left_out);
    if (answers && row.between.n > 0 && row.between.*value <= error &&
        (best == nullptr || row.spacing_m > best->spacing_m))
      best = &row;
  }
  return best;
}

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
    some.sets.active = spread_nodes(some.mesh.nodes, some.mesh.surface, some.sets.active, row.spacing_m, 0);
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
