#include "findings.hpp"

#include <array>
#include <limits>

namespace phynness::study {
namespace {

/// Median over the nodes, in per cent, by x.
Series medians(const CaseResult& result, NodeCurve curve, double NetworkErrors::*error) {
  return over_nodes("", LineStyle::line, 0, result.measured.nodes, curve, error, median_of);
}

double last(const Series& series) { return series.y.empty() ? 0 : series.y.back() / 100; }

std::string at_smallest(const Series& series) {
  const auto best = std::min_element(series.y.begin(), series.y.end()) - series.y.begin();
  const auto at = static_cast<std::size_t>(best);
  return fmt::format("{:g} ({:.2f} %)", series.x[at], series.y[at]);
}

/// Time per vertex from the coarsest to the finest level.
double per_vertex_us(const RuntimeTimes& times, double SurfaceLevel::*time) {
  const auto &coarse = times.levels.front(), &fine = times.levels.back();
  return (fine.*time - coarse.*time) / static_cast<double>(fine.vertices - coarse.vertices);
}

}  // namespace

std::string against(const std::string& a, double of_a, const std::string& b, double of_b) {
  std::string words = fmt::format("{} {} %, {} {} %", a, percent(of_a), b, percent(of_b));
  if (of_b > 0) words += fmt::format(", ratio {:.2g}", of_a / of_b);
  return words;
}

void Finding::add(const CaseResult& of, const std::string& words) {
  if (!words.empty()) _words += (_words.empty() ? " " : "; ") + of.of.title + ": " + words;
}

std::string Finding::sentence() const { return _words.empty() ? "" : _what + "." + _words + ". "; }

std::string peaks_of_histograms(const std::vector<const CaseResult*>& cases) {
  Finding found(fmt::format("Where most pairs of the paper's test lie, in bins of {:g} %", 100 * error_bin));
  for (const auto* result : cases) {
    const auto& nodes = result->measured.nodes;
    std::string words;
    for (std::size_t h = 0; !nodes.empty() && h < nodes.front().histograms.size(); ++h) {
      Histogram sum;
      for (const auto& node : nodes) add(sum, node.histograms[h].held);
      const auto peak = std::max_element(sum.begin(), sum.end()) - sum.begin();
      words += fmt::format("{}{} neurons from {:.1f} %", h == 0 ? "" : ", ", nodes.front().histograms[h].neurons,
                           100 * error_bin * static_cast<double>(peak));
    }
    found.add(*result, words);
  }
  return found.sentence();
}

std::string fresh_against_held(const std::vector<const CaseResult*>& cases, NodeCurve curve,
                               double PredictorAtNode::*linear) {
  Finding found("With the most neurons, median of nodes");
  for (const auto* result : cases) {
    const auto held = medians(*result, curve, &NetworkErrors::held_mean),
               fresh = medians(*result, curve, &NetworkErrors::fresh_mean);
    if (fresh.y.empty()) continue;
    const double by_linear = node_median(result->measured.nodes, [&](const auto& n) { return n.linear.*linear; });
    found.add(*result, against("fresh", last(fresh), "as the paper", last(held)) + ", the linear predictor " +
                           percent(by_linear) + " %");
  }
  return found.sentence();
}

std::string best_x(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x) {
  Finding found("Median of nodes, the " + x + " with the smallest error");
  for (const auto* result : cases) {
    const auto held = medians(*result, curve, &NetworkErrors::held_mean),
               fresh = medians(*result, curve, &NetworkErrors::fresh_mean);
    if (held.y.empty()) continue;
    found.add(*result, fmt::format("as the paper {}, fresh {}, tried from {:g} to {:g}", at_smallest(held),
                                   at_smallest(fresh), held.x.front(), held.x.back()));
  }
  return found.sentence();
}

std::string last_against_first(const std::vector<const CaseResult*>& cases, NodeCurve curve, const std::string& x) {
  Finding found("Median of nodes, as the paper, by " + x);
  for (const auto* result : cases) {
    const auto held = medians(*result, curve, &NetworkErrors::held_mean);
    if (held.y.size() < 2) continue;
    const auto size = [&](double n) { return fmt::format("{:g} {}", n, x); };
    found.add(*result, against(size(held.x.back()), last(held), size(held.x.front()), held.y.front() / 100) +
                           ", smallest at " + at_smallest(held));
  }
  return found.sentence();
}

std::string never_enough(const std::vector<const CaseResult*>& cases) {
  Finding found(
      fmt::format("Nodes where no size keeps the largest error of the paper's test within {:g} %", 100 * noticeable));
  for (const auto* result : cases) {
    const auto& nodes = result->measured.nodes;
    const auto needed = neurons_needed(result->measured, false);
    std::array<std::size_t, 2> never{}, all{};  // elsewhere, beside the fixed nodes
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      ++all[nodes[n].beside_fixed];
      never[nodes[n].beside_fixed] += needed[n] == 0;
    }
    found.add(*result,
              fmt::format("{} of {} beside the fixed ones, {} of {} elsewhere", never[1], all[1], never[0], all[0]));
  }
  return found.sentence();
}

std::string slopes(const RuntimeTimes& times) {
  if (times.levels.size() < 2) return "";
  const double networks = per_vertex_us(times, &SurfaceLevel::network_us),
               every = per_vertex_us(times, &SurfaceLevel::every_vertex_us),
               ours = per_vertex_us(times, &SurfaceLevel::ours_us);
  return fmt::format(
      "From the coarsest to the finest level a vertex more costs {:.3g} us with a network at every vertex, {:.3g} us "
      "with networks at the nodes and Loop's weights (ratio {:.3g}), {:.3g} us with the default family.",
      every, networks, every / networks, ours);
}

std::string deepest_pairs(const CaseResult& result) {
  std::vector<double> paper, coupled, linear;
  std::size_t better = 0;
  for (const auto& pair : result.measured.pairs) {
    if (pair.depths.empty()) continue;
    const auto& deepest = pair.depths.back();
    paper.push_back(deepest.paper_mean);
    coupled.push_back(deepest.coupled_mean);
    linear.push_back(deepest.linear_mean);
    better += deepest.coupled_mean < deepest.paper_mean;
  }
  if (paper.empty()) return "";
  Finding found("At the greatest depth that each pair was solved to, median of pairs");
  found.add(result, against("coupled", median(coupled), "weights (15)-(16)", median(paper)) +
                        fmt::format(", the linear predictor {} %, coupled smaller at {} of {} pairs",
                                    percent(median(linear)), better, paper.size()));
  return found.sentence();
}

std::string locking(const CaseResult& locked, const CaseResult& free, const std::vector<double>& ratios) {
  if (ratios.empty()) return "";
  std::string words = fmt::format("At rest {} is {:.2f} times as stiff as {} (median of {} nodes, {:.2f} to {:.2f}).",
                                  locked.measured.element, median(ratios), free.measured.element, ratios.size(),
                                  *std::min_element(ratios.begin(), ratios.end()), largest_of(ratios));
  const auto held = [](const CaseResult& of) {
    return medians(of, &NodeMeasurements::by_neurons, &NetworkErrors::held_mean);
  };
  const auto a = held(locked), b = held(free);
  if (a.y.empty() || b.y.empty()) return words;
  return words + fmt::format(" Networks of {:g} neurons, mean error of the displacement as the paper: {}.", a.x.back(),
                             against(locked.measured.element, last(a), free.measured.element, last(b)));
}

std::string plain_loop_against_ours(const RuntimeTimes& times) {
  if (!(times.deformation_us > 0)) return "";
  return fmt::format(
      "On one core of this machine the straight loop takes {:.2f} us for a deformation, the runtime {:.2f} us, "
      "ratio {:.2g}.",
      times.deformation_plain_us, times.deformation_us, times.deformation_plain_us / times.deformation_us);
}

std::string finest_level(const RuntimeTimes& times) {
  if (times.levels.empty() || !(times.levels.back().network_us > 0)) return "";
  const auto& fine = times.levels.back();
  return fmt::format(
      "At {} vertices a network at every vertex takes {:.3g} ms, networks at the nodes and Loop's weights {:.3g} ms, "
      "ratio {:.3g}.",
      fine.vertices, 1e-3 * fine.every_vertex_us, 1e-3 * fine.network_us, fine.every_vertex_us / fine.network_us);
}

}  // namespace phynness::study
