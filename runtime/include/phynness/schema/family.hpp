// Response models that phynness trains and evaluates: what decides the sections of a model and how it is evaluated.
#pragma once

#include <stdint.h>

namespace phynness {

/// The numbers are those of images (formats/image.md).
enum class Family : uint32_t { rbfn, linear, modal };

namespace schema {

/// In scenes, models and options, by the number of a family.
inline constexpr const char* family_words[] = {"rbfn", "linear", "modal"};
inline constexpr uint32_t n_families = sizeof family_words / sizeof *family_words;

/// What everything asks of a family that does not train or evaluate it. Without pointers, which would need memory on
/// devices that keep constants in flash.
struct FamilyTraits {
  bool has_energy;    ///< the force is the gradient of an energy
  bool has_levels;    ///< smaller networks beside the full one
  bool proportional;  ///< to the displacement: exact at any depth, and only for bodies of the linear law
  bool has_modes;     ///< shared by all nodes; displacements count in max_displacement_m; there may be scalar fields
};
/// By the number of a family.
inline constexpr FamilyTraits families[n_families] = {
    {false, true, false, false},
    {true, false, true, false},
    {true, true, false, true},
};

constexpr const char* word(Family family) { return family_words[static_cast<uint32_t>(family)]; }
constexpr const FamilyTraits& traits(Family family) { return families[static_cast<uint32_t>(family)]; }

}  // namespace schema
}  // namespace phynness
