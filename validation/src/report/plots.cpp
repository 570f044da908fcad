#include "plots.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <phynness/formats/error.hpp>
#include <phynness/validation/report.hpp>

namespace phynness {
namespace report {
namespace {

std::string output_of(const std::string& command) {
  std::string out;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return out;
  std::array<char, 4096> part;
  for (std::size_t n = 0; (n = std::fread(part.data(), 1, part.size(), pipe)) > 0;)
    out.append(part.data(), n);
  return pclose(pipe) == 0 ? out : "";
}

/// Between single quotes nothing is special to gnuplot but the quote.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') out += '\'';
    out += c;
  }
  return out + "'";
}

/// As one word to a shell.
std::string shell_word(const std::string& text) {
  std::string out = "'";
  for (const char c : text) {
    if (c == '\'') {
      out += "'\\''";
    } else {
      out += c;
    }
  }
  return out + "'";
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/// The element alone, its colours those of the page, its ids its own.
std::string embedded(std::string svg) {
  const auto begin = svg.find("<svg");
  if (begin == std::string::npos) return "";
  svg.erase(0, begin);
  // Attributes come in both kinds of quotes.
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
  replace_all(svg, "rgb(  1,   2,   3)", "var(--model)");
  replace_all(svg, "rgb(  4,   5,   6)", "var(--linear)");
  replace_all(svg, "rgb(  7,   8,   9)", "currentColor");
  replace_all(svg, "url(#", "url(#" + own);
  return svg;
}

class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) {
    std::string name = (std::filesystem::temp_directory_path() / "phynness_plot_XXXXXX").string();
    const int file = mkstemp(name.data());
    if (file < 0) throw failure("no temporary file can be made", name, "look at the disk, or set TMPDIR");
    std::FILE* out = fdopen(file, "w");
    const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
    _path = name;
    if (std::fclose(out) != 0 || !written)
      throw failure("writing failed", name, "look at the disk, or set TMPDIR");
  }
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(_path, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  const std::filesystem::path& path() const { return _path; }

 private:
  std::filesystem::path _path;
};

}  // namespace

std::string plot(const PlotSpec& spec) {
  // Colours that stand for those of the page.
  static constexpr std::array<const char*, 3> colors{"#010203", "#040506", "#070809"};
  std::string script =
      "set terminal svg size 460,300 dynamic font 'sans,12' noenhanced\n"
      "set grid lc 'gray'\nset border 3\nset tics nomirror\nset key below samplen 2\n";
  script += fmt::format("set title {} noenhanced\nset xlabel {} noenhanced\nset ylabel {} noenhanced\n",
                        quoted(spec.title), quoted(spec.x), quoted(spec.y));
  if (spec.log_x) script += "set logscale x\nset format x '%g'\n";
  std::string drawn;
  for (std::size_t c = 0; c < spec.curves.size(); ++c) {
    const Curve& curve = spec.curves[c];
    if (curve.at.empty()) continue;
    script += fmt::format("$d{} << END\n", c);
    for (const auto& [x, y] : curve.at) script += fmt::format("{:.6g} {:.6g}\n", x, y);
    script += "END\n";
    const char* with = curve.mark == Mark::points ? "points pt 7 ps 0.5"
                       : curve.mark == Mark::line ? "lines lw 2"
                                                  : "lines lw 1.5 dt 2";
    drawn += fmt::format("{}$d{} with {} lc rgb '{}' title {} noenhanced", drawn.empty() ? "" : ", ", c, with,
                         colors.at(static_cast<std::size_t>(curve.color)), quoted(curve.title));
  }
  if (drawn.empty()) return "<p>Nothing to draw.</p>";
  script += "plot " + drawn + "\n";
  const TemporaryFile file(script);
  std::string svg = embedded(output_of("gnuplot " + shell_word(file.path().string()) + " 2>/dev/null"));
  if (svg.empty())
    throw failure("gnuplot did not draw", spec.title, "install gnuplot-nox, or leave --report out");
  return svg;
}

std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least) {
  std::map<int, int> bins;
  for (const double sample : samples)
    ++bins[static_cast<int>(std::floor(3 * std::log10(std::max(sample, least))))];
  std::vector<std::pair<double, double>> steps;
  if (bins.empty()) return steps;
  for (int bin = bins.begin()->first; bin <= bins.rbegin()->first; ++bin) {
    const auto found = bins.find(bin);
    const double share =
        found == bins.end() ? 0 : 100.0 * found->second / static_cast<double>(samples.size());
    steps.emplace_back(std::pow(10, bin / 3.0), share);
    steps.emplace_back(std::pow(10, (bin + 1) / 3.0), share);
  }
  return steps;
}

}  // namespace report

void require_plots() {
  if (report::output_of("gnuplot --version 2>/dev/null").empty())
    throw failure("a report needs gnuplot for its plots, which is not there", "gnuplot",
                  "install gnuplot-nox, or leave --report out");
}

}  // namespace phynness
