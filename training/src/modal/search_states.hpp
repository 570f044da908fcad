// Which states a search for centers compares: shared by the searches of forces and of amplitudes.
#pragma once

#include <cstddef>

namespace phynness {

/// A search over more states is slower and finds no better centers. Whole directions are left out beyond this.
inline constexpr std::size_t max_search_states = 100;

/// Displacements closer than this fraction of the largest one differ by rounding only.
inline constexpr double same_place = 1e-9;

}  // namespace phynness
