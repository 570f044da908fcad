// Element type numbers of gmsh that a reader must know in order to skip or refuse them.
#pragma once

namespace phynness::meshes {

struct ElementType {
  int nodes;  ///< 0: unknown type
  int dimension;
};

inline constexpr int gmsh_point = 15, gmsh_triangle = 2, gmsh_tetrahedron = 4;

/// Nodes and dimension of a gmsh element type; {0, 0} if unknown.
constexpr ElementType gmsh_element_type(long long type) {
  constexpr ElementType table[] = {{0, 0},  {2, 1},  {3, 2},  {4, 2},  {4, 3},  {8, 3},  {6, 3},  {5, 3},
                                   {3, 1},  {6, 2},  {9, 2},  {10, 3}, {27, 3}, {18, 3}, {14, 3}, {1, 0},
                                   {8, 2},  {20, 3}, {15, 3}, {13, 3}, {9, 2},  {10, 2}, {12, 2}, {15, 2},
                                   {15, 2}, {21, 2}, {4, 1},  {5, 1},  {6, 1},  {20, 3}, {35, 3}, {56, 3}};
  constexpr long long n = sizeof table / sizeof table[0];
  return type > 0 && type < n ? table[type] : ElementType{0, 0};
}

}  // namespace phynness::meshes
