#include <algorithm>
#include <phynness/planning/run_time.hpp>

namespace phynness {

double wall_seconds(const RunCosts& costs, int ranks) {
  const double solving =
      static_cast<double>(costs.rays) * costs.ray_s + static_cast<double>(costs.nodes + ranks - 1) * costs.setup_s;
  return costs.start_s + std::max(solving / ranks, costs.longest_s + costs.setup_s) + costs.packing_s;
}

int ranks_of_use(const RunCosts& costs) {
  int ranks = 1;
  while (ranks < costs.rays && (ranks + 1) * wall_seconds(costs, ranks + 1) <= 2 * wall_seconds(costs, 1)) ++ranks;
  return ranks;
}

}  // namespace phynness
