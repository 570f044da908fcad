// Figures 7 to 10 and 15: displacements.
#include <array>
#include <cmath>
#include <map>

#include "findings.hpp"

namespace phynness::study {
namespace {

constexpr std::size_t shown_bins = 40;

/// Cases whose deformation networks are studied, in the order of the paper.
std::vector<const CaseResult*> studied(const PaperStudy& study) {
  std::vector<const CaseResult*> found;
  for (const char* id : {"3", "3-p1-p1", "4"})
    if (const auto* result = ran(study, id)) found.push_back(result);
  return found;
}

std::string conditions_of_studied(const std::vector<const CaseResult*>& cases) {
  std::string out;
  for (const auto* result : cases) out += (out.empty() ? "" : ". ") + conditions(*result);
  return out.empty() ? "Case 3 and Case 4 were not run." : out + ".";
}

std::string test_words(const CaseResult& result) {
  const auto& sizes = result.measured.sizes;
  return fmt::format(
      " Each network is trained on {} pairs of one node. 'As the paper': {} other pairs of the same database, "
      "with the same 26 directions. 'Fresh': {} new solves per node in random directions and depths, at all "
      "output nodes. Lines: the median over the nodes of the mean of each node.",
      sizes.training_pairs, sizes.test_pairs, sizes.probes_per_node);
}

Panel errors_panel(const CaseResult& result, NodeCurve curve, const std::string& x) {
  const auto& nodes = result.measured.nodes;
  Panel panel{result.of.title, x, "mean relative error, %", false, true, {}};
  panel.series.push_back(
      over_nodes("networks, as the paper", LineStyle::joined, 0, nodes, curve, &NetworkErrors::held_mean, median_of));
  panel.series.push_back(
      over_nodes("fresh", LineStyle::joined, 3, nodes, curve, &NetworkErrors::fresh_mean, median_of));
  panel.series.push_back(
      over_nodes("beyond R", LineStyle::joined, 5, nodes, curve, &NetworkErrors::beyond_mean, median_of));
  const Series like = panel.series.front();
  panel.series.push_back(level("linear predictor, fresh", LineStyle::dashes, 1,
                               100 * node_median(nodes, [](const auto& n) { return n.linear.displacement; }), like));
  panel.series.push_back(level(result.measured.ours + ", fresh", LineStyle::dashes, 6,
                               100 * node_median(nodes, [](const auto& n) { return n.ours.displacement; }), like));
  return panel;
}

/// Mean, and the range over the nodes, at some sizes.
void add_rows(TextTable& table, const CaseResult& result, NodeCurve curve, const std::vector<double>& at) {
  for (const double x : at) {
    std::vector<double> held, fresh, beyond;
    for (const auto& node : result.measured.nodes)
      for (const auto& row : node.*curve)
        if (row.x == x) {
          held.push_back(row.held_mean);
          fresh.push_back(row.fresh_mean);
          beyond.push_back(row.beyond_mean);
        }
    if (held.empty()) continue;
    const auto words = [](std::vector<double> v) {
      return fmt::format("{} ({} to {})", percent(median_of(v)), percent(*std::min_element(v.begin(), v.end())),
                         percent(largest_of(v)));
    };
    table.push_back({result.of.title, fmt::format("{:g}", x), words(held), words(fresh), words(beyond)});
  }
}

PaperFigure swept(const PaperStudy& study, const char* number, const char* title, NodeCurve curve, const std::string& x,
                  const std::vector<double>& at) {
  PaperFigure figure{number, title, conditions_of_studied(studied(study)), "", "", {}, {}};
  figure.table = {{"case", x, "as the paper: mean %, median of nodes (range)", "fresh", "beyond R"}};
  for (const auto* result : studied(study)) {
    if (result == studied(study).front()) figure.conditions += test_words(*result);
    figure.panels.push_back(errors_panel(*result, curve, x));
    add_rows(figure.table, *result, curve, at);
  }
  return figure;
}

}  // namespace

PaperFigure figure_7(const PaperStudy& study) {
  PaperFigure figure{"7", "Histograms of the displacement's error", conditions_of_studied(studied(study)), "", "", {},
                     {}};
  figure.paper =
      "Case 3, 3,000 pairs: the peak lies at 5 % with 20 neurons, at 2 % with 100 and below 2 % with 300, "
      "where very "
      "few errors are beyond 6 %.";
  figure.found = peaks_of_histograms(studied(study));
  figure.table = {{"case", "neurons", "as the paper: below 2 %", "below 6 %", "fresh: below 2 %", "below 6 %"}};
  for (const auto* result : studied(study)) {
    if (result == studied(study).front()) figure.conditions += test_words(*result);
    Panel held{result->of.title + ": as the paper", "relative error, %", "share of pairs, %", false, false, {}};
    Panel fresh{result->of.title + ": fresh directions", "relative error, %", "share of pairs, %", false, false, {}};
    const auto& nodes = result->measured.nodes;
    for (std::size_t h = 0; !nodes.empty() && h < nodes.front().histograms.size(); ++h) {
      Histogram of_held, of_fresh;
      for (const auto& node : nodes) {
        add(of_held, node.histograms[h].held);
        add(of_fresh, node.histograms[h].fresh);
      }
      const int neurons = nodes.front().histograms[h].neurons;
      const std::string name = fmt::format("{} neurons", neurons);
      const std::array<int, 3> colors{5, 0, 3};
      held.series.push_back(steps(name, colors[h % 3], of_held, shown_bins));
      fresh.series.push_back(steps(name, colors[h % 3], of_fresh, shown_bins));
      figure.table.push_back({result->of.title, std::to_string(neurons), percent(share_below(of_held, 0.02)),
                              percent(share_below(of_held, 0.06)), percent(share_below(of_fresh, 0.02)),
                              percent(share_below(of_fresh, 0.06))});
    }
    figure.panels.push_back(held);
    figure.panels.push_back(fresh);
  }
  return figure;
}

PaperFigure figure_8(const PaperStudy& study) {
  auto figure = swept(study, "8", "Mean error of the displacement against neurons", &NodeMeasurements::by_neurons,
                      "neurons", {20, 50, 100, 200, 300});
  figure.paper = "100 to 300 neurons: 2 to 3 % for the liver (text); the curve falls steeply, then slowly.";
  figure.found = fresh_against_held(studied(study), &NodeMeasurements::by_neurons, &PredictorAtNode::displacement);
  return figure;
}

PaperFigure figure_9(const PaperStudy& study) {
  auto figure = swept(study, "9", "Mean error against the spread", &NodeMeasurements::by_spread,
                      "spread (scaled inputs)", {0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0, 1.25, 1.5, 2.0, 3.0});
  figure.paper = "A spread of about 0.75 is best for the liver, 1 for the drain.";
  figure.found = best_x(studied(study), &NodeMeasurements::by_spread, "spread");
  return figure;
}

PaperFigure figure_10(const PaperStudy& study) {
  auto figure = swept(study, "10", "Mean error against the number of training pairs", &NodeMeasurements::by_samples,
                      "training pairs", {500, 1000, 2000, 4000, 5000, 8000});
  figure.paper = "More pairs reduce the error, ever less so; for the drain it rises slightly beyond 4,000 pairs.";
  figure.found = last_against_first(studied(study), &NodeMeasurements::by_samples, "training pairs");
  if (const auto found = studied(study); !found.empty())
    figure.conditions += fmt::format(" {} neurons.", found.front()->measured.sizes.study_neurons);
  return figure;
}

PaperFigure figure_15(const PaperStudy& study) {
  PaperFigure figure{"15", "Two tools at once", "", "", "", {}, {}};
  figure.paper = "The error grows with depth; the maximum error for the majority of the points is within 2 to 4 %.";
  figure.table = {{"case; mean % (median of pairs)", "depth, mm", "pairs", "(15)-(16)", "below 2 %", "below 4 %",
                   "coupled", "below 2 %", "linear", "force: coupled", "each tool alone", "linear"}};
  for (const auto& result : study.cases) {
    if (!result.missing.empty() || result.measured.pairs.empty()) continue;
    std::vector<double> distances;
    for (const auto& pair : result.measured.pairs) distances.push_back(1e3 * pair.distance_m);
    std::sort(distances.begin(), distances.end());
    figure.conditions += fmt::format(
        "{}: {} pairs of random nodes {:.0f} to {:.0f} mm apart, two of the exploratory directions, the "
        "shallower tool "
        "at a random share of the deeper one's depth; against solves with both nodes held; errors at all "
        "output nodes "
        "but these two, over the largest displacement of that pair. ",
        conditions(result), result.measured.pairs.size(), distances.front(), distances.back());
    Panel paper{result.of.title + ": weights (15)-(16)", "relative error, %", "share of nodes, %", false, false, {}};
    Panel coupled{result.of.title + ": coupled", "relative error, %", "share of nodes, %", false, false, {}};
    std::map<int, std::vector<const TwoToolErrors*>> by_depth;  // in tenths of a millimetre
    for (const auto& pair : result.measured.pairs)
      for (const auto& errors : pair.depths)
        by_depth[static_cast<int>(std::lround(1e4 * errors.depth_m))].push_back(&errors);
    int color = 0;
    for (const auto& [depth, rows] : by_depth) {
      Histogram of_paper, of_coupled;
      std::vector<double> mean_paper, mean_coupled, mean_linear, force, alone, linear_force;
      for (const auto* row : rows) {
        add(of_paper, row->paper);
        add(of_coupled, row->coupled);
        mean_paper.push_back(row->paper_mean);
        mean_coupled.push_back(row->coupled_mean);
        mean_linear.push_back(row->linear_mean);
        force.push_back(row->coupled_force);
        alone.push_back(row->alone_force);
        linear_force.push_back(row->linear_force);
      }
      const auto both = [](const std::vector<double>& v) {
        return fmt::format("{} ({})", percent(mean_of(v)), percent(median_of(v)));
      };
      const std::string name = fmt::format("{:.1f} mm", depth / 10.0);
      static constexpr std::array<int, 6> colors{7, 3, 6, 0, 4, 5};
      paper.series.push_back(steps(name, colors[static_cast<std::size_t>(color) % 6], of_paper, shown_bins));
      coupled.series.push_back(steps(name, colors[static_cast<std::size_t>(color++) % 6], of_coupled, shown_bins));
      figure.table.push_back(
          {result.of.title, fmt::format("{:.1f}", depth / 10.0), std::to_string(rows.size()), both(mean_paper),
           percent(share_below(of_paper, 0.02)), percent(share_below(of_paper, 0.04)), both(mean_coupled),
           percent(share_below(of_coupled, 0.02)), both(mean_linear), both(force), both(alone), both(linear_force)});
    }
    figure.panels.push_back(paper);
    figure.panels.push_back(coupled);
    figure.found += deepest_pairs(result);
  }
  if (figure.conditions.empty()) figure.conditions = "Case 3 was not run.";
  return figure;
}

}  // namespace phynness::study
