#include "findings.hpp"

namespace phynness {
namespace study {

std::string conditions(const CaseResult& result) {
  const auto& m = result.measured;
  std::size_t beside = 0;
  std::string nodes;
  for (const auto& node : m.nodes) {
    beside += node.beside_fixed;
    nodes += fmt::format(" {}", node.node);
  }
  return fmt::format("{}: {}, {}{}, K/mu = {:.3g}, node probes, R = {:.3g} mm; {} nodes ({} beside the fixed ones:{})",
                     result.of.title, m.law, m.element, m.element == "P1" && m.bulk_to_shear > 20 ? " (locked)" : "",
                     m.bulk_to_shear, 1e3 * m.range_m, m.nodes.size(), beside, nodes);
}

std::vector<double> times(const std::vector<double>& values, double factor) {
  std::vector<double> out;
  for (const double v : values) out.push_back(factor * v);
  return out;
}

double mean_of(std::vector<double> values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}
double median_of(std::vector<double> values) { return median(std::move(values)); }
double largest_of(std::vector<double> values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

Series over_nodes(const std::string& name, LineStyle style, int color, const std::vector<NodeMeasurements>& nodes,
                  NodeCurve curve, double NetworkErrors::*error, double (*combine)(std::vector<double>)) {
  Series out{name, style, color, {}, {}};
  if (nodes.empty()) return out;
  for (const auto& at : nodes.front().*curve) {
    std::vector<double> values;
    for (const auto& node : nodes)
      for (const auto& row : node.*curve)
        if (row.x == at.x) values.push_back(row.*error);
    if (values.size() < nodes.size()) continue;
    out.x.push_back(at.x);
    out.y.push_back(100 * combine(values));
  }
  return out;
}

Series level(const std::string& name, LineStyle style, int color, double percent, const Series& like) {
  if (like.x.empty()) return {name, style, color, {}, {}};
  return {name, style, color, {like.x.front(), like.x.back()}, {percent, percent}};
}

Series steps(const std::string& name, int color, const Histogram& counts, std::size_t last_bin) {
  Series out{name, LineStyle::line, color, {}, {}};
  double all = 0;
  for (const auto n : counts) all += static_cast<double>(n);
  for (std::size_t b = 0; all > 0 && b < std::min(last_bin, counts.size()); ++b)
    for (const std::size_t side : {b, b + 1}) {
      out.x.push_back(100 * error_bin * static_cast<double>(side));
      out.y.push_back(100 * static_cast<double>(counts[b]) / all);
    }
  return out;
}

void add(Histogram& sum, const Histogram& more) {
  sum.resize(std::max(sum.size(), more.size()), 0);
  for (std::size_t b = 0; b < more.size(); ++b) sum[b] += more[b];
}

double share_below(const Histogram& counts, double error) {
  double below = 0, all = 0;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    all += static_cast<double>(counts[b]);
    if (static_cast<double>(b + 1) * error_bin <= error + 1e-12) below += static_cast<double>(counts[b]);
  }
  return all > 0 ? below / all : 0;
}

}  // namespace study

PaperReport paper_report(const PaperStudy& s) {
  using namespace study;
  PaperReport report;
  report.summary = summary(s);
  report.table1 = table_1(s);
  report.table2 = table_2(s);
  report.table1_paper =
      "The 12,636 precomputation cases are rays, 486 nodes x 26 directions, and the 75,660 points belong to one "
      "network: 485 nodes x 26 x 6. Table 1 gives 154 frames a second for 200 neurons, the paper's conclusions for "
      "300. The number for the drain, 23,520 points, is not 180 x 26 x 6 = 28,080.";
  report.table2_paper =
      "The network is evaluated at every fine vertex. The column 'at every vertex' is this way, written as a plain "
      "loop, on our machine; ours evaluates the network at the nodes of the coarse mesh and subdivides the "
      "displacements. Loop's scheme gives V + E vertices and 4 F triangles a level.";
  if (const auto* liver = ran(s, "3"); liver != nullptr && liver->times) {
    report.table1_found = plain_loop_against_ours(*liver->times);
    report.table2_found = finest_level(*liver->times);
  }
  for (const auto& figure : {figure_6, figure_7, figure_8, figure_9, figure_10, figure_11, figure_12, figure_13,
                             figure_14, figure_15, figure_locking})
    report.figures.push_back(figure(s));
  return report;
}

}  // namespace phynness
