// Energy, forces and stiffness of the cells of a reduced body in its modes.
#pragma once

#include "body/body.hpp"

namespace PHN_RUNTIME {

/// Cells whose rows are multiplied at once.
inline constexpr std::int32_t cells_of_panel = 8;

/// The energy at q, and its gradient. @return false where the law is not defined in a cell
bool evaluate_body(phn_body_state& state, const double* q, double& energy, double* forces);

/// Factor of the second derivative at state.q; where it is not positive definite, of one with larger diagonals.
/// @pre evaluate_body() was successful at state.q before. @return false if no such factor is found
bool renew_stiffness(phn_body_state& state);

}  // namespace PHN_RUNTIME
