#include "modal.hpp"

#include "modal_kernels.hpp"

namespace PHN_RUNTIME {

void modal_force(const ModalResponse& node, const double* d, double* force) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  best_modal_kernels().force(node.force, node.force_table, x, force);
}

double modal_energy(const ModalResponse& node, const double* d) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  return conservative_energy(node.force, x);
}

void modal_stiffness(const ModalResponse& node, const double* d, double* stiffness) {
  double x[3];
  cut(d, node.force.max_displacement, largest_modal, x);
  conservative_stiffness(node.force, x, stiffness);
}

}  // namespace PHN_RUNTIME
