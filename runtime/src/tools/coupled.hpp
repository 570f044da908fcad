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

/// Components of the displacements of tools are clamped to this, in max_displacement_m; in linear models to
/// largest_linear.
inline constexpr double largest_coupled = 1e3;

/// Largest number of active nodes of a point: the corners of its triangle.
inline constexpr std::int32_t most_nodes = 3;

/// A touched point, whose tool prescribes the weighted mean displacement of up to three nodes. p is the part of the
/// point's displacement that its own tool causes.
struct Constraint : Place {
  Matrix stiffness;                                    ///< A of the point at rest, symmetric [N/m]
  Matrix stiffness_root, compliance_root, compliance;  ///< A^1/2, A^-1/2, A^-1
  Matrix remaining_part;                 ///< part of a displacement that remains when the others hold their points
  Matrix node_contribution[most_nodes];  ///< Q_i: contribution q_i = Q_i p of node i
  Matrix node_displacement[most_nodes];  ///< M_i: displacement e_i = M_i p of node i
  double node_factor[most_nodes];        ///< s_i: the scalar for which s_i e_i is nearest to q_i
  Matrix node_stiffness[most_nodes];     ///< K_i of the nodes at rest [N/m]
  double nonlinearity;                   ///< mean of its nodes, see nonlinearity()
  double rotation_area;                  ///< of the triangles around the point, see find_rotation() [m^2]
  Vector displacement, force;            ///< p [m]; force at the tool [N]
  double energy;                         ///< of p alone, without the energy of its nodes [J]
  double response_factor[most_nodes];    ///< the response at p, see displacement_of()
  Vector response_displacement[most_nodes];
};

/// The part of the field of a node besides its basis, see displacement_of().
struct FieldPart {
  double factor;
  Vector displacement;
};

/// The latest tools, their solution, and working memory. Quantity t is the displacement of tool t's point; quantity
/// max_tools + t is the rotation of the surface around that point [rad]. Nodes are counted in the order of each tool.
struct Coupling {
  std::int32_t max_tools, n_tools;
  int warnings;            ///< of the nodes of the latest tools
  const phn_model* model;  ///< the level of the latest tools
  const schema::Neighbours* neighbours;
  std::int32_t n_corners;             ///< largest number of nodes of a point
  Constraint* point;                  ///< of each tool
  std::int32_t n_sets;                ///< number of partial fields, each of which is rotated before all are added
  ArrayView<FieldPart> field;         ///< (set, tool, node)
  ArraysView field_basis;             ///< (set, tool, node): n_basis numbers
  Vector* field_rotation;             ///< of each set, see rotated()
  double* kernel_scratch;             ///< for the shared modes
  ArrayView<NodeField> response;      ///< (quantity, tool, node): the quantity under the node of the tool
  ArrayView<Matrix> rest_response;    ///< (quantity, tool, node): its derivative at rest
  ArraysView rest_gradient;           ///< (0, tool, node): 3 x n_basis numbers
  ArraysView response_basis;          ///< (0, tool, node): n_basis numbers, the response at p
  NodeField pair_field;               ///< scratch: the field of one node under another
  SurfaceRotation* surface_rotation;  ///< scratch
  MatrixView<Matrix> stiffness;       ///< (tool, tool): K of the points at rest
  MatrixView<Matrix> derivative;      ///< (quantity, tool): by the p of the tool
  MatrixView<Vector> residual;    ///< (order, tool): displacement that the order leaves to the tool, rotated back [m]
  MatrixView<Vector> multiplier;  ///< (order, tool): force of the residual in the undeformed body [N]
  MatrixView<Vector> residual_rotation;        ///< (order, tool): rotation by which the residual is rotated back
  Vector *single_force, *correction, *forces;  ///< of each tool: its force alone; correction of its point; its force
  double *energy, *weight;                     ///< of the orders
  double *basis, *gradient, *mode_scratch;
  double *rest_matrix, *work, *vectors;  ///< dense, with as many rows as unknowns
};

/// Whether the model answers one tool only: a round one, or one at a node.
inline bool has_round_tools(const Coupling& coupling) { return coupling.neighbours != nullptr; }

struct CoupledResult {
  bool settled;     ///< whether all points follow their tools
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
/// Computes the answers of phn_couple and phn_coupled_deform; forces are in data.coupling. @return a status of
/// phynness.h
int couple_tools(const phn_model& model, phn_data& data, std::int32_t n_tools, const phn_tool* tools,
                 phn_coupled& result);
/// @param out  n_output x 3, zeros
int field_of_tools(const phn_model& model, phn_data& data, double* out);

}  // namespace PHN_RUNTIME
