// Energy, forces and stiffness of the cells of a reduced body in its modes.
#pragma once

#include "body/body.hpp"

namespace PHN_RUNTIME {

/// Cells whose rows are multiplied at once; a panel has room for the rows of all tools, too.
inline constexpr std::int32_t cells_of_panel = 8;
static_assert(9 * cells_of_panel >= 3 * PHN_MOST_COUPLED);

/// Energy, its gradient and b at point.q. @return false where the law is not defined in a cell
bool evaluate_body(phn_body_state& state, phn_body_state::Point& point);

/// Sets state.rounding. @return false where the law is not defined at rest
bool find_rounding(phn_body_state& state);

/// The stiffness at rest, where the state is. @return false if there is no factor
bool start_stiffness(phn_body_state& state);
/// The same again.
void release_stiffness(phn_body_state& state);

/// Puts the second derivatives of the cells that changed most into the stiffness, and makes its factor. Where it is not
/// positive definite, its diagonal is raised.
/// @param n_cells  at most
/// @return false if there is no factor
bool renew_stiffness(phn_body_state& state, std::int32_t n_cells);

}  // namespace PHN_RUNTIME
