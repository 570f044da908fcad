// Evaluation of family modal: formats/model.md, "Family `modal`". All arguments d are 3 [m], finite;
// components beyond 1e6 max_displacement_m are cut there.
#pragma once

#include "model.hpp"

namespace PHN_RUNTIME {

/// @param force  3 [N]
void modal_force(const ModalResponse& node, const double* d, double* force);
/// @return [J]
double modal_energy(const ModalResponse& node, const double* d);
/// @param stiffness  3 x 3 [N/m]
void modal_stiffness(const ModalResponse& node, const double* d, double* stiffness);

/// Values of a field at all output nodes, 0 or greater.
/// @param scratch  as model.n_scratch  @param out  n_output
void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out);

}  // namespace PHN_RUNTIME
