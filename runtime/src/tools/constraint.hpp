// A touched point in a model of node probes: its tool prescribes the weighted mean displacement of up to three nodes.
#pragma once

#include "tools/node_field.hpp"
#include "tools/round_tool.hpp"

namespace PHN_RUNTIME {

/// Largest number of active nodes of a point: the corners of its triangle.
inline constexpr std::int32_t most_nodes = 3;

/// p is that part of the point's displacement which its own tool causes.
struct Constraint : Place {
  Matrix stiffness;                       ///< A: of the point at rest, symmetric [N/m]
  Matrix root, inverse_root, compliance;  ///< A^1/2, A^-1/2, A^-1
  Matrix relative;                        ///< part of a displacement that remains when the others hold their points
  Matrix contribution[most_nodes];        ///< Q_i: contribution q_i = Q_i p of node i
  Matrix reach[most_nodes];               ///< M_i: displacement e_i = M_i p of node i
  double share[most_nodes];               ///< s_i: the scalar for which s_i e_i is nearest to q_i
  Matrix rest_stiffness[most_nodes];      ///< K_i of the nodes [N/m]
  double curved;                          ///< squared deviation of its nodes' forces from linear ones, see curvature
  double area;                            ///< of the triangles around the point, see next_turn [m^2]
  Vector own, force;                      ///< p [m]; at the tool [N]
  double energy;                          ///< of p alone, without that of its nodes [J]
  double response_share[most_nodes];      ///< the response at p: see displacement_of
  Vector response_own[most_nodes];
};

/// A node's part of the field besides its basis: see displacement_of.
struct FieldPart {
  double share;
  Vector own;
};

}  // namespace PHN_RUNTIME
