// Pages of reports: titles, texts, tables, charts and pictures as JSON, and the HTML of them, which needs no script.
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
/// @param more  "caption"; "log_x" and "log_y", true: logarithmic; "range" of the vertical axis, two numbers
Json chart(const std::string& title, const std::string& x, const std::string& y, const std::vector<Curve>& curves,
           const Json& more = Json::object());

/// @param blocks  each an object with one of these keys; null: nothing
///   text, warning, remark   a paragraph
///   list       titles and sentences
///   table      rows of cells; the first row is the head. A cell is a text, or {"text", "case"}, which links to the
///              picture of this case. With "folded", a title, it is folded; with "words", true, its cells are words
///   charts     of chart()
///   pictures   each {"svg", "caption"}, whose SVG is inserted as it is; with "case", its number; with "scale", the
///              texts at the ends of the colours
Json section(const std::string& title, const std::vector<Json>& blocks);

/// A complete page that loads nothing from elsewhere. All texts are set as texts. @param sections  of section()
std::string page(const std::string& title, const std::vector<Json>& sections);

}  // namespace phynness::report
