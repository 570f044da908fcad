// Expected errors of forces by locking, from measured ratios (docs/theory.md, Why P1 locks).
#pragma once

#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

/// The material of the body or of a region with the largest K/mu, in which an element locks most.
const Material& most_locked(const Scene& scene);

/// Expected ratio of the force of the scene's element to that of Taylor-Hood on the same mesh, at this K/mu and the
/// largest displacement, interpolated in the table of the element: the mean over bodies, which differ by the factors
/// below. 1: the element does not lock, or K/mu is below the table.
/// @param mean_edge_m  of the mesh; 0: unknown, a displacement of one edge is assumed
double expected_force_ratio(const Scene& scene, double mean_edge_m = 0);

/// Means of single bodies over the table. Lowest: a liver with edges of 12.7 mm, P1, K/mu = 100, 3.7 instead of 10.
/// Highest: a liver of 507 nodes, P1, K/mu = 20, 6.1 instead of 3.8.
inline constexpr double lowest_of_bodies = 0.37, highest_of_bodies = 1.6;

/// Smallest ratio with a warning. The default element differs from Taylor-Hood by about as much on coarse meshes, and
/// the noticeable difference of forces is about 7 % (Pang, Tan and Durlach 1991, Perception & Psychophysics 49).
inline constexpr double warned_force_ratio = 1.1;

/// "4.5 times too large", "12 % too large", "right within 5 %", "20 % too small".
std::string ratio_in_words(double ratio);

/// Warnings about allowed values that usually give bad results, one sentence each, with file and line.
/// @param mean_edge_m  of the scene's mesh; 0: unknown
std::vector<std::string> scene_warnings(const Scene& scene, double mean_edge_m = 0);

}  // namespace phynness
