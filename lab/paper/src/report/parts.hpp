// Functions that several parts of the report use.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <phynness/studies/report.hpp>

namespace phynness::study {

constexpr double noticeable = 0.10;  ///< of a force, at human fingertips (paper, section 3)

inline std::string percent(double fraction) {
  const double value = 100 * fraction;
  return value > 0 && value < 0.005 ? fmt::format("{:.0e}", value) : fmt::format("{:.2f}", value);
}
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto n = values.size();
  return n % 2 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
}

/// Mean of a number over the nodes.
template <typename Number>
double node_mean(const std::vector<NodeMeasurements>& nodes, const Number& number) {
  double sum = 0;
  for (const auto& node : nodes) sum += number(node);
  return nodes.empty() ? 0 : sum / static_cast<double>(nodes.size());
}
/// Median over the nodes. Where the body snaps, the errors of a node are much larger than those of others and would
/// dominate a mean.
template <typename Number>
double node_median(const std::vector<NodeMeasurements>& nodes, const Number& number) {
  std::vector<double> values;
  for (const auto& node : nodes) values.push_back(number(node));
  return median(std::move(values));
}

/// The case of this name, or null if it was not run.
inline const CaseResult* ran(const PaperStudy& study, const std::string& id) {
  for (const auto& one : study.cases)
    if (one.of.id == id && one.missing.empty()) return &one;
  return nullptr;
}
/// K/mu, element, probe, R, nodes: conditions that every figure must state.
std::string conditions(const CaseResult& result);

using NodeCurve = std::vector<NetworkErrors> NodeMeasurements::*;
/// A statistic over the nodes at each x that all nodes have.
Series over_nodes(const std::string& name, LineStyle style, int color, const std::vector<NodeMeasurements>& nodes,
                  NodeCurve curve, double NetworkErrors::*error, double (*combine)(std::vector<double>));
/// Every value times `factor`.
std::vector<double> times(const std::vector<double>& values, double factor);
double mean_of(std::vector<double> values);
double median_of(std::vector<double> values);
double largest_of(std::vector<double> values);
/// A constant value over the x of another series.
Series level(const std::string& name, LineStyle style, int color, double percent, const Series& like);
/// Step curve of counts, in per cent.
Series steps(const std::string& name, int color, const Histogram& counts, std::size_t last_bin);
void add(Histogram& sum, const Histogram& more);
double share_below(const Histogram& counts, double error);

PaperFigure figure_6(const PaperStudy& study);
PaperFigure figure_7(const PaperStudy& study);
PaperFigure figure_8(const PaperStudy& study);
PaperFigure figure_9(const PaperStudy& study);
PaperFigure figure_10(const PaperStudy& study);
PaperFigure figure_11(const PaperStudy& study);
PaperFigure figure_12(const PaperStudy& study);
PaperFigure figure_13(const PaperStudy& study);
PaperFigure figure_14(const PaperStudy& study);
PaperFigure figure_15(const PaperStudy& study);
PaperFigure figure_locking(const PaperStudy& study);

/// Smallest number of neurons for which the largest force error of the paper's test is below the noticeable difference,
/// by node; 0: no number is sufficient.
std::vector<int> neurons_needed(const CaseMeasurements& measured, bool fresh);
/// Their median, and the number of nodes for which no number is sufficient.
std::string needed_words(const CaseMeasurements& measured, bool fresh);

TextTable summary(const PaperStudy& study);
TextTable table_1(const PaperStudy& study);
TextTable table_2(const PaperStudy& study);

}  // namespace phynness::study
