// Pages of reports: titles, texts, tables and charts as JSON, which the script of web/report draws.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace phynness::report {

using Json = nlohmann::ordered_json;

struct Curve {
  std::string title;
  const char* mark = "line";  ///< "line", "dashes", "dotted", "points" or "joined" points
  int color = 0;              ///< 0: the model; 1: the linear predictor; 2: the finite elements, text; 3 ... 7: others
  std::vector<std::pair<double, double>> at;
};

/// @param x, y  titles of the axes
/// @param more  keys of Chart in web/report/src/data.ts: log_x, log_y, range, caption
Json chart(const std::string& title, const std::string& x, const std::string& y, const std::vector<Curve>& curves,
           const Json& more = Json::object());

/// @param blocks  each an object as Block of web/report/src/data.ts, such as {"text", "..."} or {"table", rows}
Json section(const std::string& title, const std::vector<Json>& blocks);

/// @throws Error (input) in a build without pages
void require_page();

/// A complete page that loads nothing from elsewhere. @param sections  of section()
/// @throws Error (input) in a build without pages
std::string page(const std::string& title, const std::vector<Json>& sections);

}  // namespace phynness::report
