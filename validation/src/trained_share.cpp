#include <fmt/core.h>

#include <algorithm>
#include <phynness/formats/database.hpp>
#include <phynness/validation/trained_share.hpp>

namespace phynness {
namespace {

constexpr std::size_t most_named = 8;

/// Directions that a scene does not ask for (hemisphere) have the depth 0, as those whose first increment failed.
std::ptrdiff_t requested(const ActiveNodeModel& node, double range_m) {
  const auto& depths = node.trained_depth_m;
  const auto less = std::ranges::count_if(depths, [&](double depth) { return depth < range_m; });
  return std::ssize(depths) - std::clamp(less - node.n_incomplete, std::ptrdiff_t{0}, std::ranges::count(depths, 0.0));
}

}  // namespace

TrainedShare trained_share(const Model& model) {
  TrainedShare share;
  double all = 0, rays = 0;
  for (const auto& node : model.nodes) {
    double sum = 0;
    for (const double depth : node.trained_depth_m) sum += part_of_volume(depth, model.max_displacement_m);
    const auto n = static_cast<double>(requested(node, model.max_displacement_m));
    share.of_node.push_back(n > 0 ? sum / n : 0);
    all += sum;
    rays += n;
  }
  share.all = rays > 0 ? all / rays : 0;
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
