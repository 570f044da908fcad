// Tools anywhere on the surface, several at once: superposed responses of single nodes whose displacements and
// forces are solved for (docs/theory.md, coupled superposition).
#pragma once

#include "arena.hpp"
#include "local_response.hpp"

namespace phynness::runtime {

/// More tools than this are not coupled: the cost grows with the cube.
inline constexpr std::int32_t most_coupled = 16;

/// Components of what a tool asks for are cut here, in max_displacement_m; linear models at largest_linear.
inline constexpr double largest_coupled = 1e3;

/// Touched nodes and their displacements, kept from one call to the next, and scratch. N = 3 max_tools.
struct Coupling {
  std::int32_t max_tools, n_tools, n_nodes;
  std::int32_t* active;       ///< N positions among the active nodes
  double* displacement;       ///< N x 3 [m]
  double* force;              ///< max_tools x 3 [N], at the tools
  double* weight;             ///< max_tools x N: of each node in each tool's point
  std::int32_t* old_active;   ///< N
  double* old_displacement;   ///< N x 3
  double *node_force, *step;  ///< N x 3
  double* compliance;         ///< N x 9
  double *moved, *jacobian;   ///< max_tools x N x 3 and x 9: what a node does to a tool's point
  LocalResponse* local;       ///< max_tools x N
  double *basis, *gradient, *kernel;
  double *matrix, *right;     ///< (3 max_tools)^2 and 3 max_tools
};

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

/// A point of the surface: up to three vertices (phn_model::triangles) and barycentric weights.
struct SurfacePoint {
  std::int32_t vertex[3];
  double weight[3];
};

/// What the tools touch from now on. Nodes that were touched before keep their displacement.
/// @param active  n_nodes positions among the active nodes; @param weight n_tools x n_nodes
void begin_coupling(Coupling& coupling, std::int32_t n_tools, std::int32_t n_nodes, const std::int32_t* active,
                    const double* weight);

struct CoupledResult {
  bool settled;             ///< forces at the nodes balance those of the tools
  double residual;          ///< largest distance between a tool's point and where the tool holds it [m]
  double energy;            ///< [J]; 0 where the family has none
  std::int32_t iterations;
};

/// Solves for coupling.displacement and coupling.force. @pre begin_coupling
/// @param points  n_tools; @param targets n_tools x 3 [m], finite
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const SurfacePoint* points,
                            const double* targets);

}  // namespace phynness::runtime
