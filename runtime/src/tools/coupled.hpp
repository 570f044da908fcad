// Several tools anywhere on the surface, computed from the responses of single nodes (docs/theory.md, tools anywhere).
#pragma once

#include "tools/local_response.hpp"
#include "tools/round_tool.hpp"
#include "tools/surface_turn.hpp"

namespace PHN_RUNTIME {

/// Largest number of tools; memory and time grow with its square.
inline constexpr std::int32_t most_coupled = PHN_MOST_COUPLED;

/// Components of a tool's displacement are clamped to this, in max_displacement_m; in linear models to largest_linear.
inline constexpr double largest_coupled = 1e3;

/// A tool at a point between up to most_corners active nodes; p is that part of the point's displacement which the tool
/// itself causes.
struct HeldPoint : Place {
  Mean mean;                            ///< of round tools only
  Matrix scale;                         ///< of round tools only: see match_round_tools
  Vector middle;                        ///< of round tools only [m]
  double spread;                        ///< of round tools only: mean square distance of what they press from it [m^2]
  Matrix stiffness;                     ///< A: of the point at rest, symmetric [N/m]
  Matrix contribution[most_corners];    ///< Q_i: contribution q_i = Q_i p of node i
  Matrix reach[most_corners];           ///< M_i: displacement e_i = M_i p of node i
  double share[most_corners];           ///< s_i: the scalar for which s_i e_i is nearest to q_i
  Matrix rest_stiffness[most_corners];  ///< K_i of the nodes [N/m]
  Matrix root, inverse_root, compliance;  ///< A^1/2, A^-1/2, A^-1
  Matrix relative;                        ///< part of a displacement that remains when the others hold their points
  double curved;                          ///< squared deviation of its nodes' forces from linear ones, see curvature
  double area;                            ///< of the triangles around the point, see next_turn [m^2]
  Vector own, force;                      ///< p [m]; at the tool [N]
  double energy;                          ///< of p alone, without that of its nodes [J]
  double node_share[most_corners];
  Vector node_own[most_corners];  ///< the response at p: see local_displacement
};

/// A node's contribution to the field besides its basis: see local_displacement.
struct FieldPart {
  double share;
  Vector own;
};

/// The latest tools, their solution, and working memory. Place t is the displacement of tool t's point; place
/// max_tools + t is the rotation of the surface around that point [rad].
struct Coupling {
  std::int32_t max_tools, n_tools;
  bool settled;
  bool beyond;             ///< a round tool's force is beyond those that it was trained to alone
  const phn_model* model;  ///< the level of the latest tools
  Neighbours neighbours;
  std::int32_t n_corners;  ///< largest number of nodes of a point
  HeldPoint* point;        ///< max_tools
  LocalResponse* local;    ///< of place t under node i of tool s, at n_corners (t max_tools + s) + i
  Matrix* rest_response;   ///< as local: its derivative at rest
  double* rest_gradient;   ///< of node i of tool s, at n_corners s + i: 3 x n_basis
  double* node_basis;      ///< n_basis each: the response at p
  std::int32_t n_sets;     ///< of fields, each of which is turned as a whole by field_turn before they are added
  FieldPart* field;        ///< of node i of tool s in set q, at n_corners (q max_tools + s) + i
  double* field_basis;     ///< n_basis each, as field
  Vector* field_turn;      ///< see rotated
  LocalResponse pair;      ///< scratch: of one node under another
  SurfaceTurn* turn;       ///< scratch
  Matrix* stiffness;       ///< of the points at rest, of t by s at t max_tools + s
  Matrix* wide;            ///< of round tools: half of the compliance between them, see prepare_means; as stiffness
  double* vertex_mean;     ///< scratch of prepare_means
  Matrix* derivative;      ///< of place s by the p of t, at s max_tools + t
  Vector *rest, *pulled;   ///< displacement [m] left to j by order i, and its force in the undeformed body [N],
                           ///< at i max_tools + j
  Vector* left;            ///< that displacement without what stretch adds
  Vector* turned;          ///< rotation by which that displacement is turned back first, at i max_tools + j
  Vector *alone, *right, *forces;  ///< forces of single tools; displacements that points lack; forces of all tools
  double *energy, *weight;         ///< of the orders
  double *basis, *gradient, *kernel, *shared;
  double *matrix, *work, *vectors;  ///< dense, as many rows as unknowns
};

/// Number of tools that can be coupled with this data; 0 if phn_data_init made it.
inline std::int32_t most_tools(const phn_data& data) { return data.coupling == nullptr ? 0 : data.coupling->max_tools; }

Coupling lay_out_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

struct CoupledResult {
  bool settled;     ///< all points follow their tools
  bool beyond;      ///< see Coupling
  double residual;  ///< largest distance of a tool from its point in the corrected field [m]
  double energy;    ///< [J]; 0 in families without energy
};

/// @param coupling  n_tools, and nodes and weights of each point, are set
/// @param targets   n_tools [m]
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets);

/// Adds the field of the latest solution, a sum over its nodes, to `field`.
/// @param scratch    working memory, model.n_scratch
/// @param one        working memory, n_output x 3
/// @param field      n_output x 3 [m]
void coupled_field(const phn_model& model, const Coupling& coupling, PreparedNodes& prepared, double* scratch,
                   double* one, double* field);

}  // namespace PHN_RUNTIME
