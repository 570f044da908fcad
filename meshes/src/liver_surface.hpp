// The built-in organ: a liver-like body drawn by formulas, no patient's data.
#pragma once

#include <phynness/formats/scene.hpp>

#include "surface.hpp"

namespace phynness::meshes {

/// A big right lobe (negative x) that tapers to a thin left lobe (positive x), domed above (positive z),
/// hollowed below, with a notch in its front edge (negative y). Bounding box `size_m`, centred on the origin.
Surface liver_surface(const Vec3& size_m);

}  // namespace phynness::meshes
