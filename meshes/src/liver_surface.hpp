// The built-in organ: the shape of a liver from formulas, without data of a patient.
#pragma once

#include <phynness/formats/scene.hpp>

#include "surface.hpp"

namespace phynness::meshes {

/// A large right lobe (negative x) that tapers to a thin left lobe (positive x), convex above (positive z), concave
/// below, with a notch in its front edge (negative y). Bounding box `size_m`, centered at the origin.
Surface liver_surface(const Vec3& size_m);

}  // namespace phynness::meshes
