#include <cmath>
#include <phynness/formats/error.hpp>
#include <phynness/pages/pages.hpp>
#include <phynness/pages/report.hpp>

namespace phynness::report {
namespace {

/// Six digits, which is more than a picture shows.
double rounded(double x) {
  if (x == 0) return x;
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - 5);
  return std::round(x / unit) * unit;
}

}  // namespace

Json chart(const std::string& title, const std::string& x, const std::string& y, const std::vector<Curve>& curves,
           const Json& more) {
  Json drawn = Json::array();
  for (const auto& curve : curves) {
    Json along = Json::array(), up = Json::array();
    for (const auto& [a, b] : curve.at) {
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      along.push_back(rounded(a));
      up.push_back(rounded(b));
    }
    if (!along.empty())
      drawn.push_back({{"title", curve.title}, {"mark", curve.mark}, {"color", curve.color}, {"x", along}, {"y", up}});
  }
  Json all{{"title", title}, {"x", x}, {"y", y}, {"curves", drawn}};
  all.update(more);
  return all;
}

Json section(const std::string& title, const std::vector<Json>& blocks) {
  return {{"title", title}, {"blocks", blocks}};
}

void require_page() {
  if (!embedded_page("report.html"))
    throw input_error("this build has no page for reports", "report.html", missing_pages_remedy());
}

std::string page(const std::string& title, const std::vector<Json>& sections) {
  require_page();
  const Json data{{"title", title}, {"sections", sections}};
  return page_with_data(*embedded_page("report.html"),
                        data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

}  // namespace phynness::report
