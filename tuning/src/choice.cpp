#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <phynness/tuning/spacing.hpp>

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

std::string text(int what, double value) {
  char buffer[64];
  if (what == 0)
    std::snprintf(buffer, sizeof buffer, "%.3g %%", 100 * value);
  else if (what == 1)
    std::snprintf(buffer, sizeof buffer, "%.3g us", value);
  else
    std::snprintf(buffer, sizeof buffer, "%.3g MB", value / 1e6);
  return buffer;
}

std::string describe_miss(const std::vector<MeasuredModel>& models, const Costs& limit, ErrorStatistic statistic) {
  const std::array<const char*, 3> what_of{row_of(statistic).name, "time of a deformation", "memory"};
  const auto costs_of = [&](const MeasuredModel& m) { return costs(m, statistic); };
  if (std::none_of(models.begin(), models.end(), [&](const auto& m) { return std::isfinite(m.error(statistic)); }))
    return "no probe inside the trained range was solved, so that the errors are unknown";
  std::string said;
  for (int k = 0; k < 3; ++k) {
    const auto best = std::min_element(models.begin(), models.end(), [&](const auto& a, const auto& b) {
      return costs_of(a)[static_cast<std::size_t>(k)] < costs_of(b)[static_cast<std::size_t>(k)];
    });
    const double least = costs_of(*best)[static_cast<std::size_t>(k)], allowed = limit[static_cast<std::size_t>(k)];
    if (least <= allowed) continue;
    char times[32];
    std::snprintf(times, sizeof times, "%.3g", least / allowed);
    if (!said.empty()) said.append("; ");
    said.append(what_of[static_cast<std::size_t>(k)]).append(": the smallest is ").append(text(k, least));
    said.append(" (").append(best->candidate.name).append("), ").append(times);
    said.append(" times the limit of ").append(text(k, allowed));
  }
  if (!said.empty()) return said;
  // Each limit can be met by some model. The model with the smallest factor above its limits is reported.
  const auto worst = [&](const MeasuredModel& m) {
    double ratio = 0;
    for (std::size_t k = 0; k < 3; ++k) ratio = std::max(ratio, costs_of(m)[k] / limit[k]);
    return ratio;
  };
  const auto nearest =
      std::min_element(models.begin(), models.end(), [&](const auto& a, const auto& b) { return worst(a) < worst(b); });
  said.append("each limit can be met, but not all of them by the same model; the nearest model is ");
  said.append(nearest->candidate.name).append(":");
  for (int k = 0; k < 3; ++k)
    if (const double cost = costs_of(*nearest)[static_cast<std::size_t>(k)];
        cost > limit[static_cast<std::size_t>(k)]) {
      said.append(" ").append(what_of[static_cast<std::size_t>(k)]).append(" ").append(text(k, cost));
      said.append(", limit ").append(text(k, limit[static_cast<std::size_t>(k)])).append(";");
    }
  said.pop_back();
  return said;
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
      bool as_good = true, better = false;
      for (std::size_t k = 0; k < 3; ++k) {
        as_good = as_good && a[k] <= b[k];
        better = better || a[k] < b[k];
      }
      return as_good && better;
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

}  // namespace phynness
