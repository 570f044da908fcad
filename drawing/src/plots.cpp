#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <phynness/drawing/html.hpp>
#include <phynness/drawing/plots.hpp>

namespace phynness::report {
namespace {

const char* name(Mark mark) {
  switch (mark) {
    case Mark::line:
      return "line";
    case Mark::dashes:
      return "dashes";
    case Mark::dotted:
      return "dotted";
    case Mark::points:
      return "points";
    case Mark::joined_points:
      return "joined";
  }
  return "line";
}

/// Six digits, which is more than a picture shows.
double rounded(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - 5);
  return std::round(x / unit) * unit;
}

}  // namespace

std::string plot(const PlotSpec& spec) {
  nlohmann::ordered_json chart{{"title", spec.title}, {"x", spec.x},
                               {"y", spec.y},         {"log_x", spec.log_x},
                               {"log_y", spec.log_y}, {"curves", nlohmann::ordered_json::array()}};
  if (spec.high > spec.low) chart["range"] = {spec.low, spec.high};
  for (const auto& curve : spec.curves) {
    nlohmann::ordered_json x = nlohmann::ordered_json::array(), y = x;
    for (const auto& [a, b] : curve.at) {
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      x.push_back(rounded(a));
      y.push_back(rounded(b));
    }
    if (x.empty()) continue;
    chart["curves"].push_back(
        {{"title", curve.title}, {"mark", name(curve.mark)}, {"color", curve.color}, {"x", x}, {"y", y}});
  }
  if (chart["curves"].empty()) return "<p>No data.</p>";
  return "<div class=\"chart\" data-chart=\"" +
         escaped(chart.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) + "\"></div>";
}

std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least) {
  std::map<int, int> bins;
  for (const double sample : samples) ++bins[static_cast<int>(std::floor(3 * std::log10(std::max(sample, least))))];
  std::vector<std::pair<double, double>> steps;
  if (bins.empty()) return steps;
  steps.emplace_back(std::pow(10, bins.begin()->first / 3.0), 0);
  for (int bin = bins.begin()->first; bin <= bins.rbegin()->first; ++bin) {
    const auto found = bins.find(bin);
    const double share = found == bins.end() ? 0 : 100.0 * found->second / static_cast<double>(samples.size());
    steps.emplace_back(std::pow(10, bin / 3.0), share);
    steps.emplace_back(std::pow(10, (bin + 1) / 3.0), share);
  }
  steps.emplace_back(steps.back().first, 0);
  return steps;
}

}  // namespace phynness::report
