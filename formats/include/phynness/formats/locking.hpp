// How much too large the forces of an element are where it locks, by what was measured (docs/theory.md, Why P1 locks).
#pragma once

#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

/// Size of the force of the scene's element over that of Taylor-Hood on the same mesh, as it is to be expected at the
/// scene's K/mu and largest displacement: the table of the element, interpolated. 1: the element does not lock.
/// @param mean_edge_m  of the mesh; 0: unknown, a displacement of one edge is assumed
double expected_force_ratio(const Scene& scene, double mean_edge_m = 0);

/// Warned of from here on. The default element differs from Taylor-Hood by about as much on coarse meshes, and a hand
/// tells forces apart that differ by about 7 % (Pang, Tan and Durlach 1991, Perception & Psychophysics 49).
inline constexpr double warned_force_ratio = 1.1;

/// "4.5 times too large", "12 % too large", "right within 5 %", "20 % too small".
std::string ratio_in_words(double ratio);

}  // namespace phynness
