// Figures 6, 11 and 12: forces.
#include <array>
#include <cmath>
#include <limits>

#include "findings.hpp"

namespace phynness::study {
namespace {

std::vector<const CaseResult*> run_cases(const PaperStudy& study, bool networks_only) {
  std::vector<const CaseResult*> found;
  for (const auto& one : study.cases)
    if (one.missing.empty() && !(networks_only && (one.of.linear || one.of.id == "2"))) found.push_back(&one);
  return found;
}

std::string all_conditions(const std::vector<const CaseResult*>& cases) {
  std::string out;
  for (const auto* result : cases) out += conditions(*result) + ". ";
  return out;
}

/// Mean and largest |prediction - finite elements| over the largest finite element force, inside and outside of R; NaN
/// if finite elements found no equilibrium.
struct CurveError {
  double inside = 0, beyond = 0;
  bool whole_inside = false, whole_beyond = false;  ///< an equilibrium at every depth
};
CurveError curve_error(const std::vector<double>& said, const ForceCurves& curves, double range, double outside_factor,
                       int points) {
  CurveError error;
  int n_inside = 0, n_beyond = 0;
  double largest_inside = 0, largest_beyond = 0;
  for (std::size_t i = 0; i < said.size(); ++i) {
    const bool in = curves.depth_m[i] <= range * (1 + 1e-9);
    const double difference = std::abs(said[i] - curves.finite_elements[i]), size = std::abs(curves.finite_elements[i]);
    (in ? error.inside : error.beyond) += difference;
    ++(in ? n_inside : n_beyond);
    auto& largest = in ? largest_inside : largest_beyond;
    largest = std::max(largest, size);
  }
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  error.inside = n_inside > 0 && largest_inside > 0 ? error.inside / (n_inside * largest_inside) : none;
  error.beyond = n_beyond > 0 && largest_beyond > 0 ? error.beyond / (n_beyond * largest_beyond) : none;
  const int points_inside = static_cast<int>(points / outside_factor + 1e-9);
  error.whole_inside = n_inside >= points_inside;
  error.whole_beyond = n_beyond >= points - points_inside;
  return error;
}

/// Median of the nodes with a number; NaN if there is none.
double median_known(std::vector<double> values) {
  std::erase_if(values, [](double value) { return std::isnan(value); });
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : median(std::move(values));
}

/// The same, with the number of nodes that have a number for every depth.
std::string median_of_those(const std::vector<double>& values, std::size_t whole) {
  const double known = median_known(values);
  if (std::isnan(known)) return "no equilibrium";
  const std::string said = percent(known);
  return whole == values.size() ? said : fmt::format("{} ({} of {} whole)", said, whole, values.size());
}

/// Forces are drawn in mN, or in uN if they are always below 0.1 mN.
struct ForceUnit {
  const char* label;
  double per_newton;
};
ForceUnit unit_of(const std::vector<double>& forces) {
  double largest = 0;
  for (const double f : forces) largest = std::max(largest, std::abs(f));
  return largest < 1e-4 ? ForceUnit{"force, uN", 1e6} : ForceUnit{"force, mN", 1e3};
}

Panel curve_panel(const CaseResult& result, const NodeMeasurements& node) {
  const auto& c = node.curves;
  const ForceUnit unit = unit_of(c.finite_elements);
  Panel panel{fmt::format("{}, node {}{}", result.of.title, node.node, node.beside_fixed ? " (beside fixed)" : ""),
              "depth, mm",
              unit.label,
              false,
              false,
              {}};
  const auto x = times(c.depth_m, 1e3);
  panel.series.push_back({"finite elements", LineStyle::points, 2, x, times(c.finite_elements, unit.per_newton)});
  static constexpr std::array<int, 3> colors{5, 3, 0};
  for (std::size_t n = 0; n < c.networks.size(); ++n)
    panel.series.push_back({fmt::format("{} neurons", result.measured.sizes.curve_neurons[n]), LineStyle::line,
                            colors[n % 3], x, times(c.networks[n], unit.per_newton)});
  panel.series.push_back({result.measured.ours, LineStyle::dashes, 6, x, times(c.ours, unit.per_newton)});
  panel.series.push_back({"linear predictor", LineStyle::dashes, 1, x, times(c.linear, unit.per_newton)});
  double top = 0, bottom = 0;
  for (const double f : c.finite_elements) {
    top = std::max(top, unit.per_newton * f);
    bottom = std::min(bottom, unit.per_newton * f);
  }
  panel.series.push_back({"trained to",
                          LineStyle::dots,
                          7,
                          {1e3 * result.measured.range_m, 1e3 * result.measured.range_m},
                          {bottom, top}});
  // The frame cuts off curves of networks with very large errors.
  panel.low = bottom - 0.25 * (top - bottom);
  panel.high = top + 0.5 * (top - bottom);
  return panel;
}

}  // namespace

PaperFigure figure_6(const PaperStudy& study) {
  PaperFigure figure{"6", "Force against depth, beyond the calibrated range", "", "", "", {}, {}};
  figure.paper =
      "With training to 2.8 cm, predictions to 4 cm compare well with finite elements in Cases 1 to 3, "
      "better with "
      "more neurons, but for Case 2, where 100 are worse than 75.";
  figure.table = {{"case; mean error % (17) along the curve, median of nodes", "50 neurons: to R", "beyond", "75: to R",
                   "beyond", "100: to R", "beyond", "our family: to R", "beyond", "linear: to R", "beyond"}};
  Finding found("Mean error to R, median of nodes");
  for (const auto* result : run_cases(study, false)) {
    figure.conditions += conditions(*result) + ". ";
    const auto& nodes = result->measured.nodes;
    const NodeMeasurements *beside = nullptr, *other = nullptr;
    for (const auto& node : nodes) {
      auto& kind = node.beside_fixed ? beside : other;
      if (kind == nullptr) kind = &node;
    }
    for (const auto* node : {other, beside})
      if (node != nullptr && !node->curves.depth_m.empty()) figure.panels.push_back(curve_panel(*result, *node));
    std::vector<std::string> row{result->of.title};
    std::vector<double> to_range;  // by network, then the other predictors
    const auto cells = [&](const auto& of) {
      std::vector<double> inside, beyond;
      std::size_t whole_inside = 0, whole_beyond = 0;
      for (const auto& node : nodes) {
        const auto error = curve_error(of(node), node.curves, result->measured.range_m, result->measured.outside_factor,
                                       result->measured.sizes.curve_points);
        inside.push_back(error.inside);
        beyond.push_back(error.beyond);
        whole_inside += error.whole_inside;
        whole_beyond += error.whole_beyond;
      }
      to_range.push_back(median_known(inside));
      row.push_back(median_of_those(inside, whole_inside));
      row.push_back(median_of_those(beyond, whole_beyond));
    };
    for (std::size_t n = 0; n < 3; ++n)
      cells([n](const NodeMeasurements& m) {
        return n < m.curves.networks.size() ? m.curves.networks[n] : std::vector<double>{};
      });
    cells([](const NodeMeasurements& m) { return m.curves.ours; });
    cells([](const NodeMeasurements& m) { return m.curves.linear; });
    figure.table.push_back(row);
    const auto& sizes = result->measured.sizes.curve_neurons;
    const auto known = [&](std::size_t n) { return n < to_range.size() && !std::isnan(to_range[n]); };
    if (sizes.size() > 1 && known(sizes.size() - 1) && known(sizes.size() - 2))
      found.add(*result, against(fmt::format("{} neurons", sizes.back()), to_range[sizes.size() - 1],
                                 fmt::format("{} neurons", sizes[sizes.size() - 2]), to_range[sizes.size() - 2]));
  }
  figure.found = found.sentence();
  if (const auto cases = run_cases(study, false); !cases.empty())
    figure.conditions += fmt::format(
        "Force along the inward normal, trained on all increments; {} points to {:.1f} mm. Drawn: a node beside "
        "the fixed nodes and another node. Table: the median of the nodes, each up to its last equilibrium "
        "(whole: at all depths). The three solves per node of Case 1 are superposed to the 26 directions, because "
        "networks need points.",
        cases.front()->measured.sizes.curve_points,
        1e3 * cases.front()->measured.outside_factor * cases.front()->measured.range_m);
  return figure;
}

PaperFigure figure_11(const PaperStudy& study) {
  PaperFigure figure{
      "11", "Mean error of the force against neurons", all_conditions(run_cases(study, true)), "", "", {}, {}};
  figure.paper =
      "100 pairs for training and 30 others for the test; the error falls with neurons (no number in the "
      "text).";
  figure.found = fresh_against_held(run_cases(study, true), &NodeMeasurements::force_as_paper, &PredictorAtNode::force);
  figure.table = {{"case", "neurons asked for", "trained, median: as the paper, on all",
                   "as the paper: mean %, median of nodes (range)", "the same, fresh", "trained on all: fresh",
                   "beyond R"}};
  figure.conditions +=
      "Lines: the median over the nodes of each node's mean. 'All': trained on every increment. Training ends if "
      "further neurons would depend linearly on the present ones. ";
  for (const auto* result : run_cases(study, true)) {
    const auto& nodes = result->measured.nodes;
    figure.conditions += fmt::format("Spread {:.2f}, found by search. ", result->measured.force_spread);
    Panel panel{result->of.title, "neurons", "mean relative error, %", false, true, {}};
    panel.series.push_back(over_nodes("networks, as the paper", LineStyle::joined, 0, nodes,
                                      &NodeMeasurements::force_as_paper, &NetworkErrors::held_mean, median_of));
    panel.series.push_back(over_nodes("fresh", LineStyle::joined, 4, nodes, &NodeMeasurements::force_as_paper,
                                      &NetworkErrors::fresh_mean, median_of));
    panel.series.push_back(over_nodes("all increments, fresh", LineStyle::joined, 3, nodes,
                                      &NodeMeasurements::force_all, &NetworkErrors::fresh_mean, median_of));
    const Series like = panel.series.back();
    panel.series.push_back(level("linear predictor, fresh", LineStyle::dashes, 1,
                                 100 * node_median(nodes, [](const auto& n) { return n.linear.force; }), like));
    panel.series.push_back(level(result->measured.ours + ", fresh", LineStyle::dashes, 6,
                                 100 * node_median(nodes, [](const auto& n) { return n.ours.force; }), like));
    figure.panels.push_back(panel);
    for (const int asked : result->measured.sizes.force_neurons) {
      if (asked % 10 != 0) continue;
      const auto of = [&](const auto& curve, const auto& number) {
        std::vector<double> values;
        for (const auto& node : nodes)
          for (const auto& row : node.*curve)
            if (static_cast<int>(row.x) == asked) values.push_back(number(row));
        return values;
      };
      const auto errors = [&](const auto& curve, double NetworkErrors::*which) {
        const auto values = of(curve, [&](const NetworkErrors& row) { return row.*which; });
        if (values.empty()) return std::string("-");
        return fmt::format("{} ({} to {})", percent(median(values)),
                           percent(*std::min_element(values.begin(), values.end())), percent(largest_of(values)));
      };
      const auto trained = [&](const auto& curve) {
        return median(of(curve, [](const NetworkErrors& row) { return static_cast<double>(row.neurons); }));
      };
      constexpr auto pairs = &NodeMeasurements::force_as_paper, all = &NodeMeasurements::force_all;
      if (of(all, [](const NetworkErrors&) { return 0.0; }).empty()) continue;
      figure.table.push_back({result->of.title, std::to_string(asked),
                              fmt::format("{:g}, {:g}", trained(pairs), trained(all)),
                              errors(pairs, &NetworkErrors::held_mean), errors(pairs, &NetworkErrors::fresh_mean),
                              errors(all, &NetworkErrors::fresh_mean), errors(all, &NetworkErrors::beyond_mean)});
    }
  }
  return figure;
}

std::vector<int> neurons_needed(const CaseMeasurements& measured, bool fresh) {
  std::vector<int> needed;
  for (const auto& node : measured.nodes) {
    int fewest = 0;
    for (const auto& row : fresh ? node.force_all : node.force_as_paper)
      if (fewest == 0 && (fresh ? row.fresh_max : row.held_max) <= noticeable) fewest = row.neurons;
    needed.push_back(fewest);
  }
  return needed;
}

std::string needed_words(const CaseMeasurements& measured, bool fresh) {
  std::vector<double> needed;
  std::size_t never = 0;
  int most = 0;  // largest number of trained neurons
  for (const auto& node : measured.nodes)
    for (const auto& row : fresh ? node.force_all : node.force_as_paper) most = std::max(most, row.neurons);
  for (const int n : neurons_needed(measured, fresh)) {
    needed.push_back(n > 0 ? n : most + 1);
    never += n == 0;
  }
  if (never == 0) return fmt::format("{:g}", median(needed));
  if (2 * never >= needed.size())
    return fmt::format("none of up to {} suffices at {} of {} nodes", most, never, needed.size());
  return fmt::format("{:g} (none suffices at {} of {} nodes)", median(needed), never, needed.size());
}

PaperFigure figure_12(const PaperStudy& study) {
  PaperFigure figure{"12",
                     "Largest error of the force against neurons, and the just noticeable difference",
                     all_conditions(run_cases(study, true)),
                     "",
                     "",
                     {},
                     {}};
  figure.paper =
      "The largest error is below the just noticeable difference, 10 %, with 87 neurons for the liver and 63 "
      "for the drain.";
  figure.found = never_enough(run_cases(study, true));
  figure.table = {{"case", "neurons needed, as the paper: median of nodes", "range", "never (of nodes)",
                   "trained on all, fresh: median", "range", "never", "largest error of our family %: median of nodes",
                   "worst node", "linear predictor, worst node"}};
  for (const auto* result : run_cases(study, true)) {
    const auto& nodes = result->measured.nodes;
    Panel panel{result->of.title, "neurons", "largest relative error, %", false, true, {}};
    panel.series.push_back(over_nodes("as the paper, median node", LineStyle::joined, 0, nodes,
                                      &NodeMeasurements::force_as_paper, &NetworkErrors::held_max, median_of));
    panel.series.push_back(over_nodes("as the paper, worst node", LineStyle::joined, 5, nodes,
                                      &NodeMeasurements::force_as_paper, &NetworkErrors::held_max, largest_of));
    panel.series.push_back(over_nodes("all increments, fresh, median", LineStyle::joined, 3, nodes,
                                      &NodeMeasurements::force_all, &NetworkErrors::fresh_max, median_of));
    const Series like = panel.series.back();
    panel.series.push_back(level("just noticeable", LineStyle::dots, 2, 100 * noticeable, like));
    std::vector<double> ours, linear;
    for (const auto& node : nodes) {
      ours.push_back(node.ours.force_max);
      linear.push_back(node.linear.force_max);
    }
    panel.series.push_back(
        level(result->measured.ours + ", fresh, median", LineStyle::dashes, 6, 100 * median(ours), like));
    figure.panels.push_back(panel);
    std::vector<std::string> row{result->of.title};
    for (const bool fresh : {false, true}) {
      std::vector<double> found;
      for (const int n : neurons_needed(result->measured, fresh))
        if (n > 0) found.push_back(n);
      row.push_back(needed_words(result->measured, fresh));
      row.push_back(found.empty() ? "none"
                                  : fmt::format("{:g} to {:g}", *std::min_element(found.begin(), found.end()),
                                                largest_of(found)));
      row.push_back(fmt::format("{} of {}", nodes.size() - found.size(), nodes.size()));
    }
    row.push_back(percent(median(ours)));
    row.push_back(percent(largest_of(ours)));
    row.push_back(percent(largest_of(linear)));
    figure.table.push_back(row);
  }
  return figure;
}

}  // namespace phynness::study
