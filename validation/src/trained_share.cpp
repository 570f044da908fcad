#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/validation/trained_share.hpp>

namespace phynness {
namespace {

constexpr std::size_t most_named = 8;

double share_of(const ActiveNodeModel& node, double range_m) {
  double sum = 0;
  for (const double depth : node.trained_depth_m) sum += std::pow(std::min(1.0, depth / range_m), 3);
  return node.trained_depth_m.empty() ? 0 : sum / static_cast<double>(node.trained_depth_m.size());
}

}  // namespace

TrainedShare trained_share(const Model& model) {
  TrainedShare share;
  for (const auto& node : model.nodes) share.of_node.push_back(share_of(node, model.max_displacement_m));
  const double sum = std::accumulate(share.of_node.begin(), share.of_node.end(), 0.0);
  share.all = share.of_node.empty() ? 0 : sum / static_cast<double>(share.of_node.size());
  return share;
}

std::string sentence(const TrainedShare& share, const Model& model) {
  std::vector<std::size_t> less;
  for (std::size_t i = 0; i < share.of_node.size(); ++i)
    if (share.of_node[i] < 1) less.push_back(i);
  std::sort(less.begin(), less.end(), [&](auto a, auto b) { return share.of_node[a] < share.of_node[b]; });
  std::string text = fmt::format("the model is trained in {:.1f} % of the probe volume to R", 100 * share.all);
  if (less.empty()) return text;
  text += fmt::format("; in less at {} of {} nodes: ", less.size(), share.of_node.size());
  for (std::size_t i = 0; i < std::min(most_named, less.size()); ++i)
    text += fmt::format("{}{} ({:.0f} %)", i == 0 ? "" : ", ", model.nodes[less[i]].node, 100 * share.of_node[less[i]]);
  return text + (less.size() > most_named ? ", ..." : "");
}

}  // namespace phynness
