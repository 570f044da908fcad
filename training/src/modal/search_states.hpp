// Limits of the searches for centers of forces and amplitudes.
#pragma once

#include <cstddef>

namespace phynness {

/// Largest number of states in a search. With more states, which would not give better centers, complete directions are
/// omitted.
inline constexpr std::size_t max_search_states = 100;

/// Displacements whose difference is below this fraction of the largest one differ only by rounding.
inline constexpr double same_place = 1e-9;

}  // namespace phynness
