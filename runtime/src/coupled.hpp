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

/// A tool at a point: up to three active nodes; p is the displacement of the point that the tool itself causes.
struct HeldPoint {
  std::int32_t n_nodes;
  std::int32_t active[3];                 ///< positions among the active nodes
  double weight[3];                       ///< barycentric; fixed corners left out
  Matrix stiffness;                       ///< A: of the point at rest, symmetric [N/m]
  Matrix contribution[3];                 ///< Q_i: q_i = Q_i p, what node i contributes
  Matrix reach[3];                        ///< M_i: e_i = M_i p, how far node i goes
  double share[3];                        ///< s_i: q_i = s_i e_i as nearly as a number can say
  Matrix rest_stiffness[3];               ///< K_i of the nodes [N/m]
  Matrix root, inverse_root, compliance;  ///< A^1/2, A^-1/2, A^-1
  Matrix relative;                        ///< what of a displacement is left when the other tools hold their points
  double curved;                          ///< square of how far from linear its nodes' forces are, see curvature
  double area;                            ///< of the triangles around the point, see next_turn [m^2]
  Vector own, force;                      ///< p [m]; at the tool [N]
  double energy;                          ///< of p alone, without that of its nodes [J]
  double node_share[3];
  Vector node_own[3];  ///< the response at p: see local_displacement
};

/// What a node adds to the field, beside its basis: see local_displacement.
struct FieldPart {
  double share;
  Vector own;
};

/// The latest tools and their solution, and scratch. Places: that of tool t is its point's, that of max_tools
/// + t how the surface around that point turns [rad].
struct Coupling {
  std::int32_t max_tools, n_tools;
  const phn_model* model;          ///< the level of the latest tools
  HeldPoint* point;                ///< max_tools
  LocalResponse* local;            ///< of place t under node i of tool s, at 3 (t max_tools + s) + i
  Matrix* rest_response;           ///< as local: its derivative at rest
  double* rest_gradient;           ///< of node i of tool s, at 3 s + i: 3 x n_basis
  double* node_basis;              ///< n_basis each: the response at p
  std::int32_t n_sets;             ///< of fields that are turned, each as a whole, by field_turn, and then added
  FieldPart* field;                ///< of node i of tool s in set q, at 3 (q max_tools + s) + i
  double* field_basis;             ///< n_basis each, as field
  Vector* field_turn;              ///< see rotated
  LocalResponse pair;              ///< scratch: of one node under another
  SurfaceTurn* turn;               ///< scratch
  Matrix* stiffness;               ///< of the points at rest, of t by s at t max_tools + s
  Matrix* derivative;              ///< of place s by the p of t, at s max_tools + t
  Vector *rest, *pulled;           ///< what order i leaves to j [m], and the force in the undeformed body [N], at i
                                   ///< max_tools + j
  Vector* turned;                  ///< how far what is left to j is turned back before, there too: see rotated_back
  Vector *alone, *right, *forces;  ///< forces of the tools alone; what points lack; forces
  double *energy, *weight;         ///< of the orders
  double *basis, *gradient, *kernel, *shared;
  double *matrix, *work, *vectors;  ///< dense, as many rows as unknowns
};

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

struct CoupledResult {
  bool settled;     ///< all points are where their tools hold them
  double residual;  ///< largest distance between a tool's point and where the tool holds it, in the field as
                    ///< made to fit [m]
  double energy;    ///< [J]; 0 where the family has none
};

/// @param coupling  n_tools and, of each point, nodes and weights are set
/// @param targets   n_tools [m]
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets);

/// The field of the latest solution, added up over its nodes to what `field` holds.
/// @param scratch model.n_scratch; @param one, field n_output x 3 [m]: scratch and result
void coupled_field(const phn_model& model, const Coupling& coupling, PreparedNodes& prepared, double* scratch,
                   double* one, double* field);

}  // namespace PHN_RUNTIME
