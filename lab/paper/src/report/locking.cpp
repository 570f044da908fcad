// Forces of Case 3 with and without locking elements.
#include "findings.hpp"

namespace phynness::study {

PaperFigure figure_locking(const PaperStudy& study) {
  PaperFigure figure{"P1 and p1-p1", "Effect of locking on the force", "", "", "", {}, {}};
  const auto *locked = ran(study, "3"), *free = ran(study, "3-p1-p1");
  figure.paper = "The paper does not mention locking; its elements are linear tetrahedra.";
  if (locked == nullptr || free == nullptr) {
    figure.conditions = "Not run: needs Case 3 with both elements (--cases 3,3-p1-p1).";
    return figure;
  }
  figure.conditions =
      conditions(*locked) + ". " + conditions(*free) +
      ". The mesh and the nodes are the same. Stiffness at rest and curves are along the inward normal.";
  figure.table = {{"node", "P1, N/m", "p1-p1, N/m", "P1 over p1-p1"}};
  std::vector<double> ratios;
  int drawn = 0;
  for (const auto& a : locked->measured.nodes)
    for (const auto& b : free->measured.nodes) {
      if (a.node != b.node || !(b.stiffness_N_per_m > 0)) continue;
      ratios.push_back(a.stiffness_N_per_m / b.stiffness_N_per_m);
      figure.table.push_back({fmt::format("{}{}", a.node, a.beside_fixed ? " (beside fixed)" : ""),
                              fmt::format("{:.2f}", a.stiffness_N_per_m), fmt::format("{:.2f}", b.stiffness_N_per_m),
                              fmt::format("{:.2f}", ratios.back())});
      if (a.beside_fixed || drawn++ >= 2) continue;
      figure.panels.push_back(
          {fmt::format("Node {}", a.node),
           "depth, mm",
           "force, mN",
           false,
           false,
           {{"P1, as the paper", LineStyle::joined, 5, times(a.curves.depth_m, 1e3),
             times(a.curves.finite_elements, 1e3)},
            {"p1-p1", LineStyle::joined, 0, times(b.curves.depth_m, 1e3), times(b.curves.finite_elements, 1e3)}}});
    }
  figure.found = locking(*locked, *free, ratios);
  if (!ratios.empty()) figure.table.push_back({"median", "", "", fmt::format("{:.2f}", median(ratios))});
  return figure;
}

}  // namespace phynness::study
