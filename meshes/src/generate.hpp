// The surface of the built-in organ, and tetrahedra and triangles made by gmsh.
#pragma once

#include <phynness/formats/scene.hpp>

#include "surface.hpp"

namespace phynness::meshes {

/// Tetrahedra inside the surface. Its triangles become the boundary, and its nodes keep their numbers.
/// @throws Error if gmsh fails or if its tetrahedra do not fill exactly the inside
RawMesh fill(const Surface& surface);

/// Dimensions including defaults.
struct Solid {
  Shape shape = Shape::block;
  Vec3 size_m{};
  double radius_m = 0, inner_radius_m = 0, length_m = 0;
  int mirror_axis = -1;  ///< 0, 1, 2: the mesh is made symmetric in the centre plane across x, y or z
  double volume_m3() const;
  double area_m2() const;
};
/// Block: [0, x] x [0, y] x [0, z]. Cylinder and tube: axis z from 0 to the length.
RawMesh mesh_solid(const Solid& solid, double edge_m);

/// An open tube around z from 0 to its length; an ellipse is cut out of its upper wall (y > 0), in the middle.
struct Drain {
  double radius_m = 0, length_m = 0, slit_length_m = 0, slit_width_m = 0;
  int mirror_axis = -1;  ///< 0, 2: the mesh is made symmetric in the plane through the middle across x or z
  double area_m2() const;
};
/// Triangles of its middle surface.
RawMesh mesh_drain(const Drain& drain, double edge_m);

/// The built-in organ: the shape of a liver from formulas, without data of a patient.
/// A large right lobe (negative x) that tapers to a thin left lobe (positive x), convex above (positive z), concave
/// below, with a notch in its front edge (negative y). Bounding box `size_m`, centered at the origin.
Surface liver_surface(const Vec3& size_m);

}  // namespace phynness::meshes
