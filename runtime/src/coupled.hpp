// Tools anywhere on the surface, several at once: superposed responses of single nodes, each a secant through the
// displacement that its surroundings really have (docs/theory.md, coupled superposition).
#pragma once

#include "arena.hpp"
#include "local_response.hpp"

namespace phynness::runtime {

/// More tools than this are not coupled: memory and time grow with the square of the nodes.
inline constexpr std::int32_t most_coupled = 8;

/// Components of what a tool asks for are cut here, in max_displacement_m; linear models at largest_linear.
inline constexpr double largest_coupled = 1e3;

/// Touched nodes, what they do to each other, and scratch. N = 3 max_tools.
struct Coupling {
  std::int32_t max_tools, n_tools, n_nodes;
  std::int32_t* active;     ///< N positions among the active nodes
  double* weight;           ///< max_tools x N: of each node in each tool's point
  double* displacement;     ///< N x 3 [m]: q, what a node contributes
  double* reach;            ///< N x 3 [m]: e, where its response is taken
  double* moves;            ///< N x 3 [m]: where e should be
  double* force;            ///< max_tools x 3 [N], at the tools
  // Of each node at rest and at e.
  double *rest_stiffness, *compliance;  ///< N x 9
  double* rest_gradient;                ///< N x 3 x n_basis
  double* basis;                        ///< N x n_basis
  double* combined;                     ///< n_basis, scratch
  // Of node j under node i, at j N + i.
  LocalResponse* local;
  double *rest_response, *response;  ///< 9 each: dq_j / dd_i at rest, and the secant through e_i
  bool* together;                    ///< whether some tool holds both
  double *matrix, *right;            ///< (3 max_tools)^2 and 3 max_tools
  double* kernel;                    ///< scratch of basis_of
};

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

struct CoupledResult {
  bool settled;             ///< responses were taken where the nodes really are
  double residual;          ///< largest distance between a tool's point and where the tool holds it [m]
  double energy;            ///< [J]; 0 where the family has none
  std::int32_t iterations;
};

/// @param active  n_nodes positions among the active nodes, different ones
/// @param weight  n_tools x n_nodes, some weight of each tool and each node above 0
/// @param targets n_tools x 3 [m]
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, std::int32_t n_tools, std::int32_t n_nodes,
                            const std::int32_t* active, const double* weight, const double* targets);

/// The field of the latest solution, added up over its nodes to what `field` holds. @param scratch model.n_scratch
/// @param one, field  n_output x 3 [m]: scratch and result
void coupled_field(const phn_model& model, const Coupling& coupling, PreparedNodes& prepared, double* scratch,
                   double* one, double* field);

}  // namespace phynness::runtime
