// Energy, forces and stiffness of the cells of a reduced body in its modes.
#pragma once

#include "body/body.hpp"

namespace PHN_RUNTIME {

/// Number of cells whose rows are multiplied at once. A panel has room for the rows of all tools, too.
inline constexpr std::int32_t cells_of_panel = 8;
static_assert(9 * cells_of_panel >= 3 * PHN_MOST_COUPLED);

/// Computes energy, gradient and pressures at point.q. @return false where the law is not defined in a cell
bool evaluate_body(phn_body_state& state, phn_body_state::Point& point);

/// Sets state.energy_rounding. @return false where the law is not defined at rest
bool set_energy_rounding(phn_body_state& state);

/// Computes the stiffness at rest. @pre the state is at rest. @return false if it has no factor
bool init_stiffness(phn_body_state& state);
/// Restores the stiffness at rest.
void reset_stiffness(phn_body_state& state);

/// Replaces in the stiffness the second derivatives of those cells, at most n_cells, that changed most, and factorizes
/// it. The diagonal of a stiffness that is not positive definite is raised. @return false if it has no factor
bool update_stiffness(phn_body_state& state, std::int32_t n_cells);

}  // namespace PHN_RUNTIME
