// What the searches for centers of forces and amplitudes have in common.
#pragma once

#include <array>
#include <cstddef>

namespace phynness {

/// Shapes of the kernel that a search tries.
inline constexpr std::array shape_candidates{0.03, 0.1, 0.3, 0.6, 1.0};

/// Largest number of states in a search. With more states, which would not give better centers, complete directions are
/// omitted.
inline constexpr std::size_t max_search_states = 100;

/// Displacements whose difference is below this fraction of the largest one differ only by rounding.
inline constexpr double same_place = 1e-9;

}  // namespace phynness
