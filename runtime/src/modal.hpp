// Evaluation of family modal: formats/model.md, "Family `modal`". All arguments d are 3 [m], finite;
// components beyond 1e6 max_displacement_m are cut there.
#pragma once

#include "model.hpp"

namespace phynness::runtime {

/// @param force  3 [N]
void modal_force(const ModalResponse& node, const double* d, double* force);
/// @return [J]
double modal_energy(const ModalResponse& node, const double* d);
/// @param stiffness  3 x 3 [N/m]
void modal_stiffness(const ModalResponse& node, const double* d, double* stiffness);

/// Displacements of all output nodes, those of the probe not yet set.
/// @param amplitude  node.n_modes > 0; @param scratch shared n_modes; @param field n_output x 3 [m]
void modal_field(const phn_model& model, const ModalResponse& node, const double* amplitude, double* scratch,
                 double* field);

/// basis_i = q(x - c_i) - q(x) - at_rest_i; with zeros for at_rest and x this gives at_rest.
void amplitude_basis(const SharedModes& shared, const double* displacements, const double* x,
                     const double* at_rest, double* basis);

}  // namespace phynness::runtime
