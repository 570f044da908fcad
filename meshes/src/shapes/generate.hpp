// The surface of the built-in organ, and tetrahedra and triangles made by gmsh.
#pragma once

#include <phynness/formats/scene.hpp>

#include "surface/surface.hpp"

namespace phynness::meshes {

/// @throws Error if gmsh cannot be loaded
void require_gmsh();

/// A closed surface inside a body, at which tetrahedra end; those within it become a group of cells.
struct Inclusion {
  std::string group;
  Surface surface;
};
/// The name of the group of a region, by its position; make_mesh() resolves and drops it.
std::string inclusion_group(std::size_t region);
/// A sphere or an ellipsoid.
bool can_be_inclusion(const Region& region);
/// Of the regions that are a sphere or an ellipsoid those that lie within the body and apart from each other. Their
/// triangles are those of an icosahedron that are divided until edges are at most edge_m long, but at least once, and
/// enclose the volume of the ellipsoid.
std::vector<Inclusion> inclusions(const std::vector<Region>& regions, const Surface& body, double edge_m);
/// Whether a point is inside of a closed surface.
bool is_inside(const Surface& surface, const Eigen::RowVector3d& x);

/// Tetrahedra inside the surface. Its triangles become the boundary, and its nodes keep their numbers.
/// @throws Error if gmsh fails or if its tetrahedra do not fill exactly the inside
RawMesh fill(const Surface& surface, const std::vector<Inclusion>& inclusions = {});

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
