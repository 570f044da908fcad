#include <fmt/core.h>

#include <array>
#include <cmath>
#include <map>
#include <phynness/validation/errors_to_range.hpp>
#include <span>

namespace phynness {

std::string in_percent(double fraction) {
  if (std::isnan(fraction)) return "-";
  const double value = 100 * fraction;
  if ((value > 0 && value < 0.005) || value >= 99999.5) return fmt::format("{:.0e}", value);
  return value < 9.995   ? fmt::format("{:.2f}", value)
         : value < 99.95 ? fmt::format("{:.1f}", value)
                         : fmt::format("{:.0f}", value);
}

namespace {

struct Cell {
  std::string heading, text;
};

/// Headings and cells of what PredictionErrors describes.
/// @param brief  only means of statistics
std::vector<Cell> cells_of(const PredictionErrors& errors, bool brief) {
  std::vector<Cell> cells;
  PredictionErrors::describe(errors, [&]<class Value>(const auto&, const Value& value, const char* title) {
    if constexpr (std::is_same_v<Value, ErrorStatistics>) {
      ErrorStatistics::describe(value, [&](const std::string& key, auto statistic, const char* name = nullptr) {
        const bool mean = key == "mean";
        if (name != nullptr && (mean || !brief))
          cells.push_back({brief  ? title
                           : mean ? title + std::string(": mean")
                                  : name,
                           in_percent(static_cast<double>(statistic))});
      });
    } else {
      cells.push_back({title, in_percent(value)});
    }
  });
  return cells;
}

}  // namespace

std::string reasons(const std::vector<JudgedProbe>& unreached) {
  std::map<std::string, std::array<std::int64_t, 2>> by_reason;
  for (const auto& probe : unreached) ++by_reason[reason(probe)][probe.flagged];
  std::string list;
  for (const auto& [why, n] : by_reason)
    list += fmt::format("{}{} {} ({} without a warning)", list.empty() ? "" : ", ", n[0] + n[1], why, n[0]);
  return list;
}

std::string sentence(const JudgedProbe& p, const std::string& node) {
  const double depth_mm = 1e3 * p.depth_m();
  std::string where = fmt::format("the finite elements do not reach {:.3g} mm", depth_mm);
  if (p.reached_m >= 0)
    where = fmt::format("finite elements end at {:.3g} mm of {:.3g} mm", 1e3 * p.reached_m, depth_mm);
  return fmt::format("{} {}, direction ({:.2f} {:.2f} {:.2f}): {} ({}); the runtime {}", node, p.node,
                     1e3 * p.displacement_m[0] / depth_mm, 1e3 * p.displacement_m[1] / depth_mm,
                     1e3 * p.displacement_m[2] / depth_mm, where, reason(p), p.flagged ? "warns" : "does not warn");
}

namespace {

std::string percentages(std::span<const double> shares) {
  std::string list;
  for (std::size_t i = 0; i < shares.size(); ++i)
    list += (i == 0                   ? ""
             : i + 1 == shares.size() ? " and "
                                      : ", ") +
            (std::isnan(shares[i]) ? "-" : fmt::format("{:.1f}", 100 * shares[i]));
  return list + " %";
}

std::string sentence(const ErrorsAndBounds& bounds) {
  const auto& c = bounds.coverage;
  return fmt::format(
      "{:.1f} % of the errors of the force are below the model's bound ({} probes, weighted as random nodes would be); "
      "in the thirds of the depth {}; in quarters of the nodes, from the smallest bounds to the largest, {}; the mean "
      "bound is {:.2f} of the best constant one",
      100 * c.all, c.states, percentages(c.thirds), percentages(c.quarters), c.width);
}

}  // namespace

TableCells table_cells(const std::string& title, const std::vector<NamedErrors>& rows) {
  TableCells out{{title, "probes", "share"}};
  for (const auto& [name, errors, part_of] : rows) {
    if (part_of != nullptr && (errors->probes == 0 || errors->probes == part_of->probes)) continue;
    auto cells = cells_of(errors->model, false), linear = cells_of(errors->linear, true);
    linear.front().heading.insert(0, "linear: ");
    cells.insert(cells.end(), linear.begin(), linear.end());
    out.push_back({name, fmt::format("{} of {}", errors->solved, errors->probes), in_percent(errors->share)});
    for (const auto& [heading, text] : cells) {
      if (out.size() == 2) out.front().push_back(heading);
      out.back().push_back(text);
    }
  }
  return out;
}

TableCells table_cells(const std::string& title, const ErrorsByWarning& errors) {
  return table_cells(
      title,
      {{"all", &errors.all}, {"unflagged", &errors.unflagged, &errors.all}, {"flagged", &errors.flagged, &errors.all}});
}

std::vector<std::string> remarks(const ErrorsToRange& errors) {
  std::vector<std::string> out;
  if (errors.all.overall.probes == 0) return out;
  const std::string one = errors.counted == "nodes" ? "node" : "point";
  out.push_back(
      fmt::format("errors are divided by the largest finite element response to R of the {}; over 10 %: forces "
                  "that are off by more than a tenth of their own size",
                  one));
  out.push_back(
      fmt::format("the runtime does not warn of {} % of the probes to R; at the tenth of the {} with the most "
                  "warnings, of {} %",
                  in_percent(errors.unflagged.overall.share), errors.counted, in_percent(errors.least_unflagged)));
  if (errors.bounds) out.push_back(sentence(*errors.bounds));
  const std::string why = reasons(errors.unreached);
  out.push_back(fmt::format("{} of {} probes to R are not reached by the finite elements{}{}{}",
                            errors.unreached.size(), errors.all.overall.probes, why.empty() ? "" : ": ", why,
                            errors.beyond.probes > 0
                                ? fmt::format("; {} of {} beyond R", errors.unreached_beyond, errors.beyond.probes)
                                : ""));
  constexpr std::size_t most_named = 10;
  for (std::size_t i = 0; i < std::min(most_named, errors.unreached.size()); ++i)
    out.push_back(sentence(errors.unreached[i], one));
  if (errors.unreached.size() > most_named)
    out.push_back(fmt::format("... and {} more, all of them in the JSON", errors.unreached.size() - most_named));
  return out;
}

}  // namespace phynness
