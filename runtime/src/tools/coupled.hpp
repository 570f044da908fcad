// The tools of a phn_data and their answers: one tool that the responses of nodes answer alone, or several points of a
// model of node probes, coupled by the responses of single nodes (docs/theory.md, tools anywhere).
#pragma once

#include <phynness/phynness_tools.h>

#include "tools/node_field.hpp"
#include "tools/round_tool.hpp"
#include "tools/surface_turn.hpp"

namespace PHN_RUNTIME {

/// Largest number of tools; memory and time grow with its square.
inline constexpr std::int32_t most_coupled = PHN_MOST_COUPLED;

/// Components of a tool's displacement are clamped to this, in max_displacement_m; in linear models to largest_linear.
inline constexpr double largest_coupled = 1e3;

/// Largest number of active nodes of a point: the corners of its triangle.
inline constexpr std::int32_t most_nodes = 3;

/// A touched point, whose tool prescribes the weighted mean displacement of up to three nodes. p is that part of the
/// point's displacement which its own tool causes.
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

/// The latest tools, their solution, and working memory. Place t is the displacement of tool t's point; place
/// max_tools + t is the rotation of the surface around that point [rad].
struct Coupling {
  std::int32_t max_tools, n_tools;
  int warned;              ///< warnings of the nodes of the latest tools
  const phn_model* model;  ///< the level of the latest tools
  Neighbours neighbours;
  std::int32_t n_corners;         ///< largest number of nodes of a point
  Constraint* point;              ///< of each tool
  std::int32_t n_sets;            ///< of fields, each of which is turned as a whole by field_turn before they are added
  FieldPart* field;               ///< of node i of tool s in set q, at n_corners (q max_tools + s) + i
  double* field_basis;            ///< n_basis each, as field
  Vector* field_turn;             ///< see rotated
  double* kernel;                 ///< scratch: of the shared modes
  NodeField* displacement;        ///< of place t under node i of tool s, at n_corners (t max_tools + s) + i
  Matrix* rest_response;          ///< as displacement: its derivative at rest
  double* rest_gradient;          ///< of node i of tool s, at n_corners s + i: 3 x n_basis
  double* response_basis;         ///< n_basis each: the response at p
  NodeField pair;                 ///< scratch: of one node under another
  SurfaceTurn* turn;              ///< scratch
  Matrix* stiffness;              ///< K: of the points at rest, of t by s at t max_tools + s
  Matrix* derivative;             ///< of place s by the p of t, at s max_tools + t
  Vector *residual, *multiplier;  ///< displacement [m] that order i leaves to tool j, turned back, and its force in the
                                  ///< undeformed body [N], at i max_tools + j
  Vector* turned;                 ///< rotation by which that displacement is turned back, at i max_tools + j
  Vector *single_force, *right, *forces;  ///< of each tool alone; displacements that points lack; of all tools
  double *energy, *weight;                ///< of the orders
  double *basis, *gradient, *shared;
  double *matrix, *work, *vectors;  ///< dense, as many rows as unknowns
};

/// Whether the model answers one tool only: a round one, or one at a node.
inline bool has_round_tools(const Coupling& coupling) { return coupling.neighbours.begin != nullptr; }

struct CoupledResult {
  bool settled;     ///< all points follow their tools
  double residual;  ///< largest distance of a tool from its point in the corrected field [m]
  double energy;    ///< [J]; 0 in families without energy
};

/// @param coupling  of a model of node probes; n_tools, and nodes and weights of each point, are set
/// @param targets   n_tools [m]
CoupledResult solve_coupled(const phn_model& model, Coupling& coupling, const Vector* targets);

/// Adds the field of the latest solution, a sum over its nodes, to `field`.
/// @param scratch    working memory, model.n_scratch
/// @param one        working memory, n_output x 3
/// @param field      n_output x 3 [m]
void coupled_field(const phn_model& model, const Coupling& coupling, PreparedNodes& prepared, double* scratch,
                   double* one, double* field);

/// Components of displacements of tools between nodes, or of several, are clamped to this [m].
double largest_between_nodes(const phn_model& model);
/// The answers of phn_couple and phn_coupled_deform; forces remain in data.coupling. @return a status of phynness.h
int couple_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const phn_tool* tools,
                 phn_coupled& result);
/// @param out  n_output x 3, zeros
int field_of_tools(const phn_model& model, phn_data& data, double* out);

}  // namespace PHN_RUNTIME
