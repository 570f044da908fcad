#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
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

}  // namespace phynness
