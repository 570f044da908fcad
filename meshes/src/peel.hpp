// Removes flat tetrahedra on the surface of a generated mesh, which smoothing of inner nodes cannot improve.
#pragma once

#include "raw_mesh.hpp"

namespace phynness::meshes {

/// Removes cells of quality below `sliver_quality` that lie on the surface with exactly two faces. This swaps the
/// diagonal of a nearly plane quadrilateral of the surface. Cells whose removal would make the surface non-manifold are
/// kept.
/// @return number of removed cells
std::int32_t peel_slivers(RawMesh& raw);

}  // namespace phynness::meshes
