#include "modal.hpp"

#include <cmath>

namespace phynness::runtime {

void scaled_displacement(double max_displacement, const double* d, double* x) {
  for (int k = 0; k < 3; ++k)
    x[k] = std::fmax(-largest_modal, std::fmin(largest_modal, d[k] / max_displacement));
}

void modal_force(const ModalResponse& node, const double* d, double* force) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  conservative_force(node.force, x, force);
}

double modal_energy(const ModalResponse& node, const double* d) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  return conservative_energy(node.force, x);
}

void modal_stiffness(const ModalResponse& node, const double* d, double* stiffness) {
  double x[3];
  scaled_displacement(node.force.max_displacement, d, x);
  conservative_stiffness(node.force, x, stiffness);
}

}  // namespace phynness::runtime
