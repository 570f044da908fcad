// Expected errors of forces by locking, from measured ratios (docs/theory.md, Why P1 locks).
#pragma once

#include <phynness/formats/scene.hpp>
#include <string>

namespace phynness {

/// The material with the largest K/mu, in which an element locks most.
const Material& most_locked(const Scene& scene);

/// Expected ratio of the force of the scene's element to that of Taylor-Hood on the same mesh, at this K/mu. It is
/// interpolated in the table of the element, which has means over several bodies. The ratio is 1 if the element does
/// not lock or if K/mu is below the table.
double expected_force_ratio(const Scene& scene);

/// Smallest ratio with a warning. The default element on coarse meshes differs from Taylor-Hood by about this ratio.
/// The noticeable difference of forces is about 7 % (Pang, Tan and Durlach 1991, Perception & Psychophysics 49).
inline constexpr double warned_force_ratio = 1.1;

/// "4.5 times too large", "12 % too large", "right within 5 %", "20 % too small".
std::string ratio_in_words(double ratio);

/// Warnings about allowed values that usually give bad results, one sentence each, with file and line.
std::vector<std::string> scene_warnings(const Scene& scene);

}  // namespace phynness
