#include <algorithm>
#include <phynness/planning/scaling_curve.hpp>
#include <utility>

namespace phynness {

double efficiency(const Schedule& one_rank, const Schedule& many) {
  const double spent = many.ranks * many.wall_s;
  return spent > 0 ? one_rank.wall_s / spent : 1;
}

std::string limited_by(const Schedule& one_rank, const Schedule& many) {
  const auto &a = one_rank.spent, &b = many.spent;
  const std::pair<double, const char*> excess[] = {{b.start - a.start, "start-up"},
                                                   {b.node_setup - a.node_setup, "node set-up"},
                                                   {b.fetching - a.fetching, "fetching tasks"},
                                                   {b.writing - a.writing, "writing"},
                                                   {b.tail - a.tail, "tail of long rays"},
                                                   {b.packing - a.packing, "packing"}};
  const auto& largest = *std::max_element(std::begin(excess), std::end(excess),
                                          [](const auto& x, const auto& y) { return x.first < y.first; });
  return largest.first > 0 ? largest.second : "nothing";
}

int ranks_at_efficiency(double wanted, const Schedule& one_rank, const RayWork& work,
                        const MachineCosts& machine, const Policy& policy, int most) {
  const auto good = [&](int ranks) {
    return efficiency(one_rank, simulate(work, machine, policy, ranks)) >= wanted;
  };
  int below = 1, above = 1;
  while (below < most) {
    above = std::min(most, std::max(below + 1, static_cast<int>(1.1 * below)));
    if (!good(above)) break;
    below = above;
  }
  while (above - below > 1) {
    const int middle = below + (above - below) / 2;
    (good(middle) ? below : above) = middle;
  }
  return below;
}

}  // namespace phynness
