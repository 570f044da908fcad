// Families of response models. The family determines the sections of a model.txt and how the model is evaluated.
#pragma once

#include <stdint.h>

namespace phynness {

/// The numbers are those of images (formats/image.md).
enum class Family : uint32_t { rbfn, linear, modal };

namespace schema {

/// Names in scenes, models and options, in the order of the numbers of the families.
inline constexpr const char* family_words[] = {"rbfn", "linear", "modal"};
inline constexpr uint32_t n_families = sizeof family_words / sizeof *family_words;

/// Properties of a family for code that neither trains nor evaluates it. It has no pointers, because pointers in a
/// constant would be relocated into RAM on devices that keep constants in flash memory.
struct FamilyTraits {
  bool has_energy;    ///< the force is the gradient of an energy
  bool has_levels;    ///< may have smaller networks beside the full one
  bool proportional;  ///< responses are proportional to the displacement: exact, but only for the linear law
  bool has_modes;     ///< modes shared by all nodes, displacements in units of max_displacement_m, scalar fields
};
/// In the order of the numbers of the families.
inline constexpr FamilyTraits families[n_families] = {
    {false, true, false, false},
    {true, false, true, false},
    {true, true, false, true},
};

constexpr const char* word(Family family) { return family_words[static_cast<uint32_t>(family)]; }
constexpr const FamilyTraits& traits(Family family) { return families[static_cast<uint32_t>(family)]; }

}  // namespace schema
}  // namespace phynness
