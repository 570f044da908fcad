// Plots with the colours of the page. The page's script (web/report) draws them; without it they are left out.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace phynness::report {

enum class Mark { line, dashes, points, joined_points, dotted };

/// Colours of the page, each with a light and a dark value.
inline constexpr int n_colors = 8;

struct Curve {
  std::string title;
  Mark mark = Mark::line;
  int color = 0;  ///< 0: the model; 1: the linear predictor; 2: the finite elements, text; 3 ... 7: others
  std::vector<std::pair<double, double>> at;
};

struct PlotSpec {
  std::string title, x, y;
  bool log_x = false;
  std::vector<Curve> curves;
  bool log_y = false;
  double low = 0, high = 0;  ///< of the vertical axis; equal: chosen from the curves
};

/// An HTML element that contains the curves, for the page's script.
std::string plot(const PlotSpec& spec);

/// Percentages of samples in each third of a decade, from the smallest to the largest sample. Samples below `least`
/// count as `least`.
std::vector<std::pair<double, double>> histogram(const std::vector<double>& samples, double least);

}  // namespace phynness::report
