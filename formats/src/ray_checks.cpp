#include "ray_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "database_layout.hpp"

namespace phynness {
namespace {

namespace path = database_layout::path;

bool is_status(std::int8_t code) {
  return std::any_of(std::begin(every_status), std::end(every_status),
                     [&](Status status) { return static_cast<std::int8_t>(status) == code; });
}

template <class Value>
std::string tell(const std::string& dataset, std::size_t index, Value value, const char* of = "increment") {
  char buffer[32];
  return dataset + ", " + of + " " + std::to_string(index) + ", is " +
         std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

/// The first value of a converged increment that is not within +-`most`.
template <class IsConverged>
std::string first_beyond(const std::string& dataset, const std::vector<double>& values, std::size_t increments,
                         const IsConverged& is_converged, double most) {
  const std::size_t per_increment = values.size() / increments;
  for (std::size_t i = 0; i < increments; ++i) {
    if (!is_converged(i)) continue;
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(i * per_increment);
    const auto end = begin + static_cast<std::ptrdiff_t>(per_increment);
    const auto found = std::find_if_not(begin, end, [&](double v) { return std::abs(v) <= most; });
    if (found != end) return tell(dataset, i, *found);
  }
  return "";
}

constexpr double finite = std::numeric_limits<double>::max();

}  // namespace

std::string figures_defect(const StateFigures& figures) {
  for (std::size_t i = 0; i < figures.status.size(); ++i)
    if (!is_status(figures.status[i])) return tell(path::status, i, static_cast<int>(figures.status[i]));
  const auto negative = [](const char* dataset, const auto& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!(values[i] >= 0) || !(static_cast<double>(values[i]) <= finite)) return tell(dataset, i, values[i]);
    return std::string();
  };
  for (const auto& defect :
       {negative(path::negative_pivots, figures.negative_pivots), negative(path::iterations, figures.iterations),
        negative(path::cutbacks, figures.cutbacks), negative(path::seconds, figures.seconds)})
    if (!defect.empty()) return defect;
  if (figures.status.empty()) return "";
  return first_beyond(
      path::min_jacobian, figures.min_jacobian, figures.status.size(),
      [&](std::size_t i) { return figures.status[i] == static_cast<std::int8_t>(Status::converged); }, finite);
}

std::string ends_defect(const std::vector<RayEnd>& ends) {
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const RayEnd& end = ends[i];
    if (std::find(std::begin(every_end), std::end(every_end), end.reason) == std::end(every_end))
      return tell(path::end_reason, i, static_cast<int>(end.reason), "ray");
    if (!(end.depth_m >= 0) || end.depth_m > finite) return tell(path::end_depth, i, end.depth_m, "ray");
    if (!(end.fold_depth_m >= 0) || end.fold_depth_m > finite)
      return tell(path::fold_depth, i, end.fold_depth_m, "ray");
    if (!(std::abs(end.energy_lost_J) <= finite)) return tell(path::energy_lost, i, end.energy_lost_J, "ray");
  }
  return "";
}

std::string ray_defect(const Ray& ray, const std::vector<Field>& fields, double farthest_m) {
  StateFigures figures{{}, ray.negative_pivots, ray.iterations, ray.cutbacks, ray.min_jacobian, ray.seconds};
  for (const auto status : ray.status) figures.status.push_back(static_cast<std::int8_t>(status));
  if (auto defect = figures_defect(figures); !defect.empty()) return defect;
  if (auto defect = ends_defect({ray.end}); !defect.empty()) return defect;
  const auto check = [&](const std::string& dataset, const std::vector<double>& values, double most) {
    return first_beyond(
        dataset, values, ray.status.size(), [&](std::size_t i) { return ray.status[i] == Status::converged; }, most);
  };
  auto defect = check(path::force, ray.force, finite);
  if (defect.empty()) defect = check(path::energy, ray.energy, finite);
  if (defect.empty()) defect = check(path::tangent, ray.tangent, finite);
  if (defect.empty()) defect = check(path::displacement, ray.displacement, farthest_m);
  for (std::size_t f = 0; f < fields.size() && defect.empty(); ++f)
    defect = check(database_layout::path_of(fields[f]), ray.fields[f], finite);
  return defect;
}

}  // namespace phynness
