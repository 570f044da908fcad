// The surface of the built-in organ, and tetrahedra and triangles made by gmsh.
#pragma once

#include <phynness/formats/scene.hpp>

#include "surface/surface.hpp"

namespace phynness::meshes {

/// @throws Error if gmsh cannot be loaded
void require_gmsh();

/// Tetrahedra inside the surface. Its triangles become the boundary, and its nodes keep their numbers.
/// @throws Error if gmsh fails or if its tetrahedra do not fill exactly the inside
RawMesh fill(const Surface& surface);

/// A block [0, x] x [0, y] x [0, z], or a cylinder or tube with the axis z from 0 to the length.
/// @param spec         with all dimensions
RawMesh mesh_solid(const MeshSpec& spec, double edge_m);
/// The triangles of an open tube around z from 0 to its length; an ellipse is cut out of its upper wall (y > 0), in the
/// middle.
RawMesh mesh_drain(const MeshSpec& spec, double edge_m);

/// The built-in organ: the shape of a liver from formulas, without data of a patient.
/// A large right lobe (negative x) that tapers to a thin left lobe (positive x), convex above (positive z), concave
/// below, with a notch in its front edge (negative y). Bounding box `size_m`, centered at the origin.
Surface liver_surface(const Vec3& size_m);

}  // namespace phynness::meshes
