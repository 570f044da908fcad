// Expected errors of forces by locking, from measured ratios (docs/theory.md, Why P1 locks).
#pragma once

#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

/// The material with the largest K/mu, in which an element locks most.
const Material& most_locked(const Scene& scene);

/// Expected ratio of the force of the scene's element to that of Taylor-Hood on the same mesh, at this K/mu and at the
/// largest displacement. It is interpolated in the table of the element, which has means over several bodies. The ratio
/// is 1 if the element does not lock or if K/mu is below the table.
/// @param mean_edge_m  mean edge of the mesh; 0 (unknown) assumes that the displacement is one edge
double expected_force_ratio(const Scene& scene, double mean_edge_m = 0);

/// Extreme ratios of a single body to the mean in the table: a liver with edges of 12.7 mm, P1, K/mu = 100 (3.7 instead
/// of 10), and a liver of 507 nodes, P1, K/mu = 20 (6.1 instead of 3.8).
inline constexpr double lowest_of_bodies = 0.37, highest_of_bodies = 1.6;

/// Smallest ratio with a warning. The default element on coarse meshes differs from Taylor-Hood by about this ratio.
/// The noticeable difference of forces is about 7 % (Pang, Tan and Durlach 1991, Perception & Psychophysics 49).
inline constexpr double warned_force_ratio = 1.1;

/// "4.5 times too large", "12 % too large", "right within 5 %", "20 % too small".
std::string ratio_in_words(double ratio);

/// Warnings about allowed values that usually give bad results, one sentence each, with file and line.
/// @param mean_edge_m  mean edge of the scene's mesh; 0 if it is unknown
std::vector<std::string> scene_warnings(const Scene& scene, double mean_edge_m = 0);

}  // namespace phynness
