// What the module phynness_gmsh.so makes. It alone is linked with gmsh, because the loading of gmsh takes 0.1 s:
// programs load it when they make their first mesh.
#pragma once

#include "generate.hpp"

namespace phynness::meshes {

struct Drain {
  double radius, length, slit_length, slit_width;
};

/// gmsh compares with absolute tolerances, so that all lengths are given in edge lengths. Each function throws an Error
/// with what gmsh says.
struct GmshModule {
  /// Tetrahedra inside a closed surface. Its nodes come first, in their order.
  RawMesh (*fill)(const Surface& surface, const std::vector<Inclusion>& inclusions);
  /// A box, or a cylinder or tube around z from 0 to size[2]. Edges have the length 1.
  /// @param size  of a box; radius, radius and length of the others
  RawMesh (*solid)(Shape shape, const Vec3& size, double inner_radius);
  /// Triangles of the drain. Edges have the length 1.
  RawMesh (*drain)(const Drain& drain);
};

extern "C" const GmshModule phynness_gmsh;

}  // namespace phynness::meshes
