// Tools anywhere on the surface, several at once, from the responses of single nodes (docs/theory.md, tools
// anywhere).
#pragma once

#include "arena.hpp"
#include "local_response.hpp"
#include "surface_turn.hpp"

namespace PHN_RUNTIME {

/// More tools than this are not coupled: memory and time grow with the square.
inline constexpr std::int32_t most_coupled = 8;

/// Components of what a tool asks for are cut here, in max_displacement_m; linear models at largest_linear.
inline constexpr double largest_coupled = 1e3;

/// A tool at a point: up to three active nodes. Matrices are 3 x 3, p is the displacement of the point that
/// the tool itself causes.
struct HeldPoint {
  std::int32_t n_nodes;
  std::int32_t active[3];                          ///< positions among the active nodes
  double weight[3];                                ///< barycentric; fixed corners left out
  double stiffness[9];                             ///< A: of the point at rest, symmetric [N/m]
  double contribution[3][9];                       ///< Q_i: q_i = Q_i p, what node i contributes
  double reach[3][9];                              ///< M_i: e_i = M_i p, how far node i goes
  double share[3];                                 ///< s_i: q_i = s_i e_i as nearly as a number can say
  double rest_stiffness[3][9];                     ///< K_i of the nodes [N/m]
  double root[9], inverse_root[9], compliance[9];  ///< A^1/2, A^-1/2, A^-1
  double relative[9];                    ///< what of a displacement is left when the other tools hold their points
  double curved;                         ///< square of how far from linear its nodes' forces are, see curvature
  double area;                           ///< of the triangles around the point, see next_turn [m^2]
  double own[3], force[3];               ///< p [m]; at the tool [N]
  double energy;                         ///< of p alone, without that of its nodes [J]
  double node_share[3], node_own[3][3];  ///< the response at p: see local_displacement
};

/// What a node adds to the field, beside its basis: see local_displacement.
struct FieldPart {
  double share, own[3];
};

/// The latest tools and their solution, and scratch. Places: that of tool t is its point's, that of max_tools
/// + t how the surface around that point turns [rad].
struct Coupling {
  std::int32_t max_tools, n_tools;
  const phn_model* model;           ///< the level of the latest tools
  HeldPoint* point;                 ///< max_tools
  LocalResponse* local;             ///< of place t under node i of tool s, at 3 (t max_tools + s) + i
  double* rest_response;            ///< 9 each, as local: its derivative at rest
  double* rest_gradient;            ///< of node i of tool s, at 3 s + i: 3 x n_basis
  double* node_basis;               ///< n_basis each: the response at p
  std::int32_t n_sets;              ///< of fields that are turned, each as a whole, by field_turn, and then added
  FieldPart* field;                 ///< of node i of tool s in set q, at 3 (q max_tools + s) + i
  double* field_basis;              ///< n_basis each, as field
  double* field_turn;               ///< 3 each: see rotate
  LocalResponse pair;               ///< scratch: of one node under another
  SurfaceTurn* turn;                ///< scratch
  double* stiffness;                ///< of the points at rest, of t by s at 9 (t max_tools + s)
  double* derivative;               ///< of place s by the p of t, at 9 (s max_tools + t)
  double *rest, *pulled;            ///< what order i leaves to j [m], and the force in the undeformed body [N], at 9 i
                                    ///< max_tools + 3 j
  double* turned;                   ///< how far what is left to j is turned back before, there too: see rotate
  double *energy, *weight, *alone;  ///< of the orders; forces of the tools alone
  double *basis, *gradient, *kernel, *shared, *matrix, *work, *vectors, *right, *forces;
};

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

struct CoupledResult {
  bool settled;     ///< all points are where their tools hold them
  double residual;  ///< largest distance between a tool's point and where the tool holds it, in the field as
                    ///< made to fit [m]
  double energy;    ///< [J]; 0 where the family has none
};

/// @param coupling  n_tools and, of each point, nodes and weights are set
/// @param targets   n_tools x 3 [m]
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const double* targets);

/// The field of the latest solution, added up over its nodes to what `field` holds.
/// @param scratch model.n_scratch; @param one, field n_output x 3 [m]: scratch and result
void coupled_field(const phn_model& model, const Coupling& coupling, PreparedNodes& prepared, double* scratch,
                   double* one, double* field);

}  // namespace PHN_RUNTIME
