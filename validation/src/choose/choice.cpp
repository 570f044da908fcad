#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <phynness/validation/tuning.hpp>

namespace phynness {
namespace {

/// The quantities with the two limits: error and time.
using Costs = std::array<double, 2>;

Costs costs(const MeasuredModel& m) { return {m.error(), m.speed.deformation_us}; }

std::string text(std::size_t what, double value) {
  return what == 0 ? fmt::format("{:.3g} %", 100 * value) : fmt::format("{:.3g} us", value);
}

std::string unmet_limits(const std::vector<MeasuredModel>& models, const Costs& limit) {
  constexpr std::array what_of{"mean error", "time of a deformation"};
  if (std::ranges::none_of(models, [&](const auto& m) { return std::isfinite(m.error()); }))
    return "no probe inside the trained range was solved, so that the errors are unknown";
  std::string unmet;
  for (std::size_t k = 0; k < 2; ++k) {
    const auto best = std::ranges::min_element(models, {}, [&](const auto& m) { return costs(m)[k]; });
    const double least = costs(*best)[k];
    if (least > limit[k])
      unmet += fmt::format("{}{}: the smallest is {} ({}), {:.3g} times the limit of {}", unmet.empty() ? "" : "; ",
                           what_of[k], text(k, least), best->candidate.name, least / limit[k], text(k, limit[k]));
  }
  if (!unmet.empty()) return unmet;
  // Each limit can be met by some model. The model with the smallest factor above its limits is reported.
  const auto nearest = std::ranges::min_element(
      models, {}, [&](const MeasuredModel& m) { return std::max(costs(m)[0] / limit[0], costs(m)[1] / limit[1]); });
  for (std::size_t k = 0; k < 2; ++k)
    if (const double cost = costs(*nearest)[k]; cost > limit[k])
      unmet +=
          fmt::format("{} {} {}, limit {}", unmet.empty() ? "" : ";", what_of[k], text(k, cost), text(k, limit[k]));
  return fmt::format("each limit can be met, but not both by the same model; the nearest model is {}:{}",
                     nearest->candidate.name, unmet);
}

}  // namespace

double MeasuredModel::error() const {
  if (errors.inside.force.n == 0) return std::numeric_limits<double>::infinity();
  return std::max(errors.inside.force.mean, errors.inside.displacement.mean);
}

void mark_front(std::vector<MeasuredModel>& models) {
  const auto all = [](const MeasuredModel& m) {
    return std::array<double, 3>{m.error(), m.speed.deformation_us, m.memory_bytes};
  };
  for (auto& m : models)
    m.on_front = std::none_of(models.begin(), models.end(), [&](const MeasuredModel& other) {
      const auto a = all(other), b = all(m);
      return a != b && a[0] <= b[0] && a[1] <= b[1] && a[2] <= b[2];
    });
}

TuningChoice choose_model(const std::vector<MeasuredModel>& models, const TuningLimits& limits) {
  constexpr double none = std::numeric_limits<double>::infinity();
  const Costs limit{limits.error.value_or(none), limits.deformation_us.value_or(none)};
  TuningChoice choice;
  const auto key = [&](const MeasuredModel& m) {
    const auto [error, time_us] = costs(m);
    return limits.error ? std::array{time_us, m.memory_bytes} : std::array{error, time_us};
  };
  for (std::size_t i = 0; i < models.size(); ++i) {
    const auto c = costs(models[i]);
    if (!std::isfinite(c[0]) || !(c[0] <= limit[0] && c[1] <= limit[1])) continue;
    if (!choice.chosen || key(models[i]) < key(models[*choice.chosen])) choice.chosen = i;
  }
  if (!choice.chosen) choice.missed = unmet_limits(models, limit);
  return choice;
}

}  // namespace phynness
