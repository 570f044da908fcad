#include <algorithm>
#include <phynness/planning/scaling_curve.hpp>
#include <utility>

namespace phynness {

double efficiency(const Schedule& one_rank, const Schedule& many) {
  const double spent = many.ranks * many.wall_s;
  return spent > 0 ? one_rank.wall_s / spent : 1;
}

namespace {

/// What ranks without a task wait for at the end.
Limit limit_of_the_end(const Schedule& many, const RayWork& work, const MachineCosts& machine) {
  if (static_cast<std::size_t>(many.ranks) >= work.n_rays()) return Limit::n_rays;
  const double solving_s = many.solved_s - machine.launch_s - machine.start_s;
  return work.longest_seconds() > solving_s / 2 ? Limit::longest_ray : Limit::last_rays;
}

}  // namespace

Limit limited_by(const Schedule& one_rank, const Schedule& many, const RayWork& work, const MachineCosts& machine) {
  const auto &a = one_rank.spent, &b = many.spent;
  const std::pair<double, Limit> excess[] = {
      {b.start - a.start, Limit::start},          {b.node_setup - a.node_setup, Limit::node_setup},
      {b.fetching - a.fetching, Limit::fetching}, {b.writing - a.writing, Limit::writing},
      {b.tail - a.tail, Limit::last_rays},        {b.packing - a.packing, Limit::packing}};
  const auto& largest = *std::max_element(std::begin(excess), std::end(excess),
                                          [](const auto& x, const auto& y) { return x.first < y.first; });
  if (!(largest.first > 0)) return Limit::nothing;
  return largest.second == Limit::last_rays ? limit_of_the_end(many, work, machine) : largest.second;
}

const char* name(Limit limit) {
  switch (limit) {
    case Limit::nothing:
      return "nothing";
    case Limit::start:
      return "start";
    case Limit::node_setup:
      return "node_setup";
    case Limit::fetching:
      return "fetching";
    case Limit::writing:
      return "writing";
    case Limit::n_rays:
      return "n_rays";
    case Limit::longest_ray:
      return "longest_ray";
    case Limit::last_rays:
      return "last_rays";
    case Limit::packing:
      return "packing";
  }
  return "unknown";
}

int ranks_at_efficiency(double wanted, const RayWork& work, const MachineCosts& machine, int most) {
  const auto one_rank = simulate(work, machine, 1);
  const auto good = [&](int ranks) { return efficiency(one_rank, simulate(work, machine, ranks)) >= wanted; };
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
