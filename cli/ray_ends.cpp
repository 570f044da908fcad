#include <algorithm>

#include "commands.hpp"

namespace phynness::cli {
namespace {

constexpr std::size_t most_listed = 8;

/// Active nodes with rays that end early, those with the smallest probe volume first.
std::vector<std::size_t> nodes_with_ends(const EndSummary& ends) {
  std::vector<std::size_t> nodes;
  for (std::size_t a = 0; a < ends.early.size(); ++a)
    if (ends.early[a] > 0) nodes.push_back(a);
  std::stable_sort(nodes.begin(), nodes.end(),
                   [&](std::size_t a, std::size_t b) { return ends.reached[a] < ends.reached[b]; });
  return nodes;
}

void print_nodes(const DatabaseHeader& header, const EndSummary& ends, const std::vector<std::size_t>& nodes) {
  std::string text;
  for (std::size_t i = 0; i < nodes.size() && i < most_listed; ++i)
    text += fmt::format("{}{} ({:.0f} %)", i ? ", " : "", header.sets.active[nodes[i]], 100 * ends.reached[nodes[i]]);
  print_result("  at {} of {} nodes; volume that is trained: {}{}\n", nodes.size(), ends.early.size(), text,
               nodes.size() > most_listed ? ", ..." : "");
}

json by_node(const DatabaseHeader& header, const EndSummary& ends, const std::vector<std::size_t>& nodes) {
  json listed = json::array();
  for (const auto a : nodes)
    listed.push_back(
        record("node", header.sets.active[a], "rays", ends.early[a], "share_of_volume_left", ends.reached[a]));
  return listed;
}

}  // namespace

json tell_ends(const DatabaseHeader& header, const EndSummary& ends) {
  json reasons = json::object();
  std::int64_t n_early = 0;
  for (const auto& [reason, count] : ends.reasons) {
    const auto lost = ends.volume.find(reason);
    reasons[name(reason)] = record("rays", count, "share_of_volume", lost == ends.volume.end() ? 0.0 : lost->second);
    if (RayEnd{reason}.is_early()) n_early += count;
  }
  const auto nodes = nodes_with_ends(ends);
  if (n_early > 0) {
    print_result("ends      {} of {} rays ({:.1f} %) end early, {:.1f} % of the probe volume is not trained\n", n_early,
                 ends.rays, 100 * ends.share_of_rays(), 100 * ends.share_of_volume());
    for (const auto& [reason, count] : ends.reasons)
      if (RayEnd{reason}.is_early()) print_result("  {:<16} {:<9} {}\n", name(reason), count, meaning(reason));
    print_nodes(header, ends, nodes);
  }
  if (ends.folds > 0)
    print_result("folds     on {} rays; the largest energy lost at once is {:.3g} J\n", ends.folds,
                 ends.largest_loss_J);
  return record("rays", ends.rays, "rays_early", n_early, "share_of_rays", ends.share_of_rays(), "share_of_volume",
                ends.share_of_volume(), "reasons", reasons, "folds", ends.folds, "largest_energy_lost_J",
                ends.largest_loss_J, "nodes", by_node(header, ends, nodes));
}

}  // namespace phynness::cli
