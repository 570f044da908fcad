#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <phynness/drawing/gnuplot.hpp>
#include <phynness/drawing/plots.hpp>
#include <phynness/formats/error.hpp>

namespace phynness::report {
namespace {

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// Colours of the page, defined by the style in html.cpp. gnuplot draws with placeholders for them: (1, 2, 3), (4, 5,
/// 6) ...
constexpr std::array<const char*, n_colors> page_colors{"var(--model)", "var(--linear)", "currentColor", "var(--c3)",
                                                        "var(--c4)",    "var(--c5)",     "var(--c6)",    "var(--c7)"};

/// The SVG element alone, with the colours of the page and with unique ids.
std::string embedded(std::string svg) {
  const auto begin = svg.find("<svg");
  if (begin == std::string::npos) return "";
  svg.erase(0, begin);
  // Attributes may have either kind of quotes.
  static int n_plots = 0;
  const std::string own = fmt::format("p{}_", ++n_plots);
  for (const char q : {'"', '\''}) {
    replace_all(svg, fmt::format("{0}black{0}", q), fmt::format("{0}currentColor{0}", q));
    replace_all(svg, fmt::format("{0}gray{0}", q), fmt::format("{0}currentColor{0}", q));
    replace_all(svg, fmt::format("stroke={0}rgb(190, 190, 190){0}", q),
                fmt::format("stroke={0}currentColor{0} stroke-opacity={0}0.25{0}", q));
    replace_all(svg, fmt::format(" id={}", q), fmt::format(" id={}{}", q, own));
    replace_all(svg, fmt::format("xlink:href={}#", q), fmt::format("xlink:href={}#{}", q, own));
  }
  for (int c = 0; c < n_colors; ++c)
    replace_all(svg, fmt::format("rgb({:3d}, {:3d}, {:3d})", 3 * c + 1, 3 * c + 2, 3 * c + 3), page_colors[c]);
  replace_all(svg, "url(#", "url(#" + own);
  return svg;
}

const char* with(Mark mark) {
  switch (mark) {
    case Mark::line:
      return "lines lw 2";
    case Mark::dashes:
      return "lines lw 1.5 dt 2";
    case Mark::dotted:
      return "lines lw 1.5 dt 3";
    case Mark::points:
      return "points pt 7 ps 0.5";
    case Mark::joined_points:
      return "linespoints lw 1.5 pt 7 ps 0.4";
  }
  return "lines";
}

}  // namespace

std::string plot(const PlotSpec& spec) {
  std::size_t n_keys = 0;
  for (const auto& curve : spec.curves) n_keys += !curve.at.empty() && !curve.title.empty();
  // The key is below the plot and the axis label, two entries per line, and does not reduce the height of the plot.
  std::string script = fmt::format(
      "set terminal svg size 460,{} dynamic font 'sans,12' noenhanced\n"
      "set grid lc 'gray'\nset border 3\nset tics nomirror\nset key below maxcols 2 samplen 2 height 1\n",
      288 + 18 * ((n_keys + 1) / 2));
  script += fmt::format("set title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n",
                        quoted(spec.title), quoted(spec.x), quoted(spec.y));
  if (spec.log_x) script += "set logscale x\nset format x '%g'\n";
  if (spec.log_y) script += "set logscale y\nset format y '%g'\n";
  if (spec.high > spec.low) script += fmt::format("set yrange [{:.6g}:{:.6g}]\n", spec.low, spec.high);
  std::string drawn;
  for (std::size_t c = 0; c < spec.curves.size(); ++c) {
    const Curve& curve = spec.curves[c];
    if (curve.at.empty()) continue;
    script += fmt::format("$d{} << END\n", c);
    for (const auto& [x, y] : curve.at) script += fmt::format("{:.6g} {:.6g}\n", x, y);
    script += "END\n";
    drawn += fmt::format("{}$d{} with {} lc rgb '#{:02x}{:02x}{:02x}' title {} noenhanced", drawn.empty() ? "" : ", ",
                         c, with(curve.mark), 3 * curve.color + 1, 3 * curve.color + 2, 3 * curve.color + 3,
                         quoted(curve.title));
  }
  if (drawn.empty()) return "<p>No data.</p>";
  script += "plot " + drawn + "\n";
  std::string svg = embedded(gnuplot(script, spec.title, "omit the report"));
  if (svg.empty()) throw failure("gnuplot drew no plot", spec.title, "install a gnuplot with the terminal svg");
  return svg;
}

std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least) {
  std::map<int, int> bins;
  for (const double sample : samples) ++bins[static_cast<int>(std::floor(3 * std::log10(std::max(sample, least))))];
  std::vector<std::pair<double, double>> steps;
  if (bins.empty()) return steps;
  for (int bin = bins.begin()->first; bin <= bins.rbegin()->first; ++bin) {
    const auto found = bins.find(bin);
    const double share = found == bins.end() ? 0 : 100.0 * found->second / static_cast<double>(samples.size());
    steps.emplace_back(std::pow(10, bin / 3.0), share);
    steps.emplace_back(std::pow(10, (bin + 1) / 3.0), share);
  }
  return steps;
}

}  // namespace phynness::report
