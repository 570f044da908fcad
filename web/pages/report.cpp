#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <phynness/formats/printable.hpp>
#include <phynness/pages/report.hpp>

#include "report_style.hpp"

namespace phynness::report {
namespace {

std::string text_of(const Json& text) { return escaped(text.get<std::string>()); }

// Of a chart, in pixels.
constexpr double left = 58, right = 460, top = 8, bottom = 226;

/// An axis of a chart: its values, and where they lie.
struct Axis {
  bool log;
  double low, high;   ///< values, or their decimal logarithms
  double begin, end;  ///< [pixels]

  double at(double value) const {
    return begin + ((log ? std::log10(value) : value) - low) / (high - low) * (end - begin);
  }
  /// Multiples of 1, 2 or 5 times a power of ten; powers of ten.
  std::vector<double> ticks() const {
    const double span = high - low;
    double step = std::pow(10, std::floor(std::log10(span / 5)));
    for (const double factor : {2.0, 2.5, 2.0})
      if (span / step > 5) step *= factor;
    if (log) step = std::max(1.0, std::round(step));
    std::vector<double> all;
    for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; ++k)
      all.push_back(log ? std::pow(10, k * step) : k * step + 0.0);  // no -0
    return all;
  }
};

/// @param key  "x" or "y"
Axis axis_of(const Json& chart, const char* key, double begin, double end) {
  const bool is_y = *key == 'y';
  Axis axis{chart.value(is_y ? "log_y" : "log_x", false), 1e300, -1e300, begin, end};
  for (const auto& curve : chart.at("curves"))
    for (const double value : curve.at(key)) {
      axis.low = std::min(axis.low, axis.log ? std::floor(std::log10(value)) : value);
      axis.high = std::max(axis.high, axis.log ? std::ceil(std::log10(value)) : value);
    }
  if (is_y && !axis.log) axis.low = std::min(axis.low, 0.0);
  if (!axis.log) axis.high += 0.03 * (axis.high - axis.low);
  if (is_y && chart.contains("range")) {
    axis.low = chart.at("range").at(0);
    axis.high = chart.at("range").at(1);
    if (axis.log) axis.low = std::log10(axis.low), axis.high = std::log10(axis.high);
  }
  if (!(axis.high > axis.low)) axis.low -= 0.5, axis.high += 0.5;
  return axis;
}

std::string drawn(const Json& chart) {
  const auto title = text_of(chart.at("title")), x_title = text_of(chart.at("x")), y_title = text_of(chart.at("y"));
  if (chart.at("curves").empty()) return fmt::format("<p>{}: no data.</p>", title);
  const Axis x = axis_of(chart, "x", left, right), y = axis_of(chart, "y", bottom, top);
  std::string grid, curves, legend;
  for (const double tick : x.ticks())
    grid += fmt::format(R"(<path d="M{0:.1f} {1}V{2}"/><text x="{0:.1f}" y="{3}" text-anchor="middle">{4:.6g}</text>)",
                        x.at(tick), top, bottom, bottom + 15, tick);
  for (const double tick : y.ticks())
    grid += fmt::format(R"(<path d="M{0} {1:.1f}H{2}"/><text x="{3}" y="{4:.1f}" text-anchor="end">{5:.6g}</text>)",
                        left, y.at(tick), right, left - 6, y.at(tick) + 4, tick);
  for (const auto& curve : chart.at("curves")) {
    const auto mark = curve.at("mark").get<std::string>();
    const int color = curve.at("color");
    std::string line, dots;
    for (std::size_t i = 0; i < curve.at("x").size(); ++i) {
      const double px = x.at(curve.at("x").at(i)), py = y.at(curve.at("y").at(i));
      line += fmt::format("{}{:.1f} {:.1f}", i == 0 ? 'M' : 'L', px, py);
      dots += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="3.5"/>)", px, py);
    }
    curves += fmt::format(R"(<g class="c{} {}"><path d="{}"/>{}</g>)", color, mark, line,
                          mark == "points" || mark == "joined" ? dots : "");
    legend += fmt::format(R"(<li class="c{}">{}</li>)", color, text_of(curve.at("title")));
  }
  return fmt::format(
      R"(<p>{0}</p><svg class="chart" viewBox="0 0 480 264" role="img" aria-label="{0}: {2} against {1}">)"
      R"(<g class="grid">{3}<text x="{4}" y="{5}" text-anchor="middle">{1}</text>)"
      R"svg(<text transform="translate(12 {6}) rotate(-90)" text-anchor="middle">{2}</text></g>)svg"
      R"(<svg x="{7}" y="{8}" width="{9}" height="{10}" viewBox="{7} {8} {9} {10}">{11}</svg></svg><ul>{12}</ul>)",
      title, x_title, y_title, grid, (left + right) / 2, bottom + 33, (top + bottom) / 2, left, top, right - left,
      bottom - top, curves, legend);
}

std::string figure(const std::string& attributes, const std::string& content, const Json& of) {
  return fmt::format("<figure{}>{}<figcaption>{}</figcaption></figure>\n", attributes, content,
                     escaped(of.value("caption", "")));
}

std::string pictured(const Json& picture) {
  std::string scale;
  if (picture.contains("scale"))
    scale = fmt::format(R"(<div class="scale">{}<i></i>{}</div>)", text_of(picture.at("scale").at(0)),
                        text_of(picture.at("scale").at(1)));
  const auto id = picture.contains("case") ? fmt::format(R"( id="case-{}")", picture.at("case").get<int>()) : "";
  return figure(id, picture.at("svg").get<std::string>() + scale, picture);
}

std::string table_of(const Json& rows, bool words) {
  std::string lines;
  for (const auto& row : rows) {
    const char* tag = lines.empty() ? "th" : "td";
    lines += "<tr>";
    for (const auto& cell : row) {
      const auto text = cell.is_object() ? cell.at("text").get<std::string>() : cell.get<std::string>();
      // Lines must not be broken after the minus of a number, and sentences among numbers are.
      const bool is_sentence = words ? text.find(' ') != std::string::npos : text.size() > 24;
      lines += fmt::format("<{}{}>{}</{}>", tag, is_sentence ? R"( class="sentence")" : "",
                           cell.is_object()
                               ? fmt::format(R"(<a href="#case-{}">{}</a>)", cell.at("case").get<int>(), escaped(text))
                               : escaped(text),
                           tag);
    }
    lines += "</tr>\n";
  }
  return fmt::format(R"(<div class="wide" tabindex="0"><table{}>{}</table></div>)", words ? R"( class="words")" : "",
                     lines);
}

std::string html_of(const Json& block) {
  std::string all;
  for (const char* key : {"text", "warning", "remark"})
    if (block.contains(key)) return fmt::format(R"(<p class="{}">{}</p>)", key, text_of(block.at(key)));
  if (block.contains("list")) {
    for (const auto& line : block.at("list"))
      all += fmt::format("<li><strong>{}</strong>: {}</li>\n", text_of(line.at(0)), text_of(line.at(1)));
    return "<ul>" + all + "</ul>";
  }
  if (block.contains("table")) {
    all = table_of(block.at("table"), block.value("words", false));
    if (!block.contains("folded")) return all;
    return fmt::format("<details><summary>{}</summary>{}</details>", text_of(block.at("folded")), all);
  }
  if (block.contains("charts"))
    for (const auto& chart : block.at("charts")) all += figure("", drawn(chart), chart);
  if (block.contains("pictures"))
    for (const auto& picture : block.at("pictures")) all += pictured(picture);
  return R"(<div class="plots">)" + all + "</div>";
}

}  // namespace

Json chart(const std::string& title, const std::string& x, const std::string& y, const std::vector<Curve>& curves,
           const Json& more) {
  Json drawn = Json::array();
  for (const auto& curve : curves) {
    Json along = Json::array(), up = Json::array();
    for (const auto& [a, b] : curve.at) {
      if (!std::isfinite(a) || !std::isfinite(b)) continue;
      along.push_back(a);
      up.push_back(b);
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

std::string page(const std::string& title, const std::vector<Json>& sections) {
  std::string body = "<h1>" + escaped(title) + "</h1>\n";
  for (const auto& section : sections) {
    const auto heading = text_of(section.at("title"));
    body += "<section>" + (heading.empty() ? "" : "<h2>" + heading + "</h2>\n");
    for (const auto& block : section.at("blocks"))
      if (!block.is_null()) body += html_of(block) + "\n";
    body += "</section>\n";
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n{}</body>\n</html>\n",
      escaped(title), report_style, body);
}

}  // namespace phynness::report
