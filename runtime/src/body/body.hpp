// A reduced body in memory, the tools on it, and its state (docs/theory.md, Reduced body).
#pragma once

#include <phynness/phynness_body.h>

#include <phynness/schema/body_grammar.hpp>
#include <phynness/schema/body_laws.hpp>

#include "core/arena.hpp"
#include "core/model.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// The constants of the law in a region of a body.
struct BodyMaterial {
  double parameters[phynness::schema::largest_parameter_count];
  double bulk;     ///< The shape has the volumetric term bulk/2 g^2.
  double modulus;  ///< largest second derivative of the shape at rest; 0 if the law is not defined there
};

/// A matrix of floats in memory of another object. Its rows are padded with zeros to whole blocks.
struct RowMatrix {
  const float* data;
  std::int64_t n_rows;
  std::int32_t stride;

  const float* operator[](std::int64_t row) const { return data + row * stride; }
};

}  // namespace PHN_RUNTIME

/// A cell is a quadrature point.
struct phn_body {
  phn_body_contents info;
  const PHN_RUNTIME::BodyLaw* law;
  const PHN_RUNTIME::BodyMaterial* materials;  ///< n_materials; the first is that of cells in no region
  const std::int32_t* material_of_cell;        ///< null: all cells have the first material
  std::int32_t n_materials;
  std::int32_t stride;  ///< length of a row of modes
  const std::int32_t* node_kinds;
  const std::int32_t* neighbors;  ///< n_triangles x 3: the triangle at the edge from corner k to k + 1; -1: none
  const double* normals;          ///< unit normals of the nodes
  const double *cell_weights, *pressure_weights;  ///< quadrature weights s_c [m^3] and v_c [J^1/2]
  PHN_RUNTIME::RowMatrix modes;                   ///< 3 n_nodes rows
  PHN_RUNTIME::RowMatrix mode_gradients;          ///< 9 n_cells rows
  /// n_modes rows each: second derivatives at rest of the energy of the cells, and of what the elements have in
  /// addition (formats/body.md, AT REST). A matrix without rows is not in the file, as for the residual compliance.
  PHN_RUNTIME::RowMatrix cells_at_rest, lack_at_rest;
  const std::int32_t* pressure_row;       ///< row of each cell in `pressure_modes`, ascending; -1: it has no pressure
  PHN_RUNTIME::RowMatrix pressure_modes;  ///< a row for each cell with a pressure
  /// n_nodes rows: the root of the compliance at rest that the modes lack at a node.
  PHN_RUNTIME::RowMatrix residual_compliance;
  const double* bounds;  ///< coefficients of core/bound.hpp, n_coupled_kinds x n_coupled_terms; null: none

  const PHN_RUNTIME::BodyMaterial& material(std::int32_t cell) const {
    return materials[material_of_cell != nullptr ? material_of_cell[cell] : 0];
  }
};

namespace PHN_RUNTIME {

/// @return a status of phynness.h; *result is null on failure and when only counting
int load_body(const char* text, std::size_t length, Arena& arena, const phn_body** result, std::size_t& wrong_byte);

/// Whether a tool may be at a node: a probe is near, or the residual compliance is known.
inline bool is_touchable(const phn_body& body, std::int32_t node) {
  return body.node_kinds[node] == phynness::schema::body_node_touchable ||
         (body.node_kinds[node] == phynness::schema::body_node_moves && body.residual_compliance.n_rows > 0);
}

/// A place of the surface.
struct BodyPlace {
  double x[3], normal[3];                               ///< at rest
  double compliance_root[phynness::schema::n_of_root];  ///< root of the residual compliance
  bool has_residual_compliance;
};

/// Working memory of set_constraint_rows.
struct ToolScratch {
  double* weight;                          ///< of each node; zeros between calls
  std::int32_t *weighted_nodes, *reached;  ///< nodes with a weight; triangles under the tool
  char* is_reached;                        ///< of each triangle; zeros between calls
};

/// Sets the three rows of the constraint of a tool: the mean displacements of the modes under it.
/// @return PHN_OK, PHN_WARNING_OUTSIDE or an error
int set_constraint_rows(phn_body_state& state, const phn_tool& tool, double* rows);

/// Distance from which on there is no spring between two tools [m].
double near_distance(const phn_body& body);

/// Sets the compliance of the springs from the places of the tools and their compliance at rest.
/// @pre state.constraint_rows are those of the tools
/// @param heights  of the tools over the surface [m]; null: zeros
void set_springs(phn_body_state& state, std::int32_t n_tools, const phn_tool* tools, const double* heights);

/// A state whose next step is larger than this part of the deformation is far from balance. The forces of the call
/// before are then returned.
inline constexpr double far_from_balance = 0.1;

/// A state in an arena, not yet at rest; null: counting, or no memory.
phn_body_state* lay_out_state(Arena& arena, const phn_body& body, std::int32_t max_tools);
/// @return a status of phynness.h
int start_state(phn_body_state& state);

/// Solves phn_body_force with further tools that are not held: no force acts on them, but springs connect them.
/// @param n_tools  number of all tools, of which the first n_held are held
/// @param forces   3 n_held forces [N], in an array of zeros for PHN_MOST_COUPLED tools
/// @return a status of phynness.h; outputs are then undefined where it is an error
int solve_body(phn_body_state& state, std::int32_t n_held, std::int32_t n_tools, const phn_tool* tools,
               const double* heights, std::int32_t steps, double* forces, phn_body_report& report);

/// Adds the displacement of a place by the forces of the last solution through the residual compliance [m].
void add_residual_displacement(const phn_body_state& state, const BodyPlace& place, double* displacement);
/// The place of a node, or of a tool.
BodyPlace place_of(const phn_body& body, std::int32_t node);
BodyPlace place_of(const phn_body& body, const phn_tool& tool);

/// Dense linear algebra, for several instruction sets (core/kernels.hpp).
struct BodyKernels {
  const char* name;
  /// out = A x
  void (*multiply_vector)(const RowMatrix& a, const double* x, double* out);
  /// out += A^T x
  void (*add_transposed_product)(const RowMatrix& a, const double* x, double* out);
  /// Upper triangle, in blocks, of out += A^T B, which is symmetric.
  void (*add_symmetric_product)(const RowMatrix& a, const RowMatrix& b, float* out);
  /// out += A^T B
  void (*add_product)(const RowMatrix& a, const RowMatrix& b, float* out);
  /// out = sum_k factor[k] rows[k], of the nine rows of a cell
  void (*combine_rows)(const float* rows, std::int32_t stride, const float* factor, float* out);
  /// Replaces the upper triangle by the Cholesky factor, with the inverses of its diagonal. @return whether it exists
  bool (*factorize)(float* a, std::int32_t n, std::int32_t stride);
  /// x = A^-1 x
  void (*solve)(const float* factor, std::int32_t n, std::int32_t stride, double* x);
};
const BodyKernels* body_kernels(int set);
const BodyKernels& best_body_kernels();

}  // namespace PHN_RUNTIME

/// The unknowns are the amplitudes q of the modes. The tools prescribe R q = d, with the constraint rows R, and their
/// forces are the multipliers. Near tools and the residual compliance act as springs in series: R q + S f = d.
struct phn_body_state {
  const phn_body* body;
  const PHN_RUNTIME::BodyKernels* kernels;
  std::int32_t max_tools;
  PHN_RUNTIME::ToolScratch scratch;
  /// Amplitudes q, with the energy, its gradient dE/dq, the amplitudes b of the pressure modes, and grad u of the
  /// cells.
  struct Point {
    double *q, *gradient, *pressures, *displacement_gradient, energy;
    float* volume_gradients;  ///< v dg/dq of the cells with a pressure
  } current, trial;
  /// b as the last step predicted it. With it in the next stiffness, and not with b, Newton's method is that of the
  /// mixed problem: b is off by the square of a step, times a bulk modulus.
  double* predicted_pressures;
  double* cell_pressures;                     ///< pressures of the cells that have one
  double energy_rounding;                     ///< rounding error of energies near rest [J]
  double *constraint_rows, *compliance_rows;  ///< 3 max_tools rows each: R, and K^-1 applied to them
  double *unconstrained_step, *step;
  double *cells_gradient, *lack_gradient;  ///< products of cells_at_rest and lack_at_rest with q
  float *factor, *factor_at_rest;          ///< Cholesky factors of the stiffness
  float* pressure_jacobian;                ///< db/dq where the factor was made, n_pressures rows
  /// S, the displacement of each row by unit forces of all [m/N].
  double spring_compliance[3 * PHN_MOST_COUPLED][3 * PHN_MOST_COUPLED];
  bool has_springs;                                 ///< whether S is not 0
  bool has_spring[PHN_MOST_COUPLED];                ///< whether one joins the tool to a near one
  bool is_definite;                                 ///< whether K + R^T H R had a factor as it was
  PHN_RUNTIME::BodyPlace places[PHN_MOST_COUPLED];  ///< of the tools
  double near_m;                                    ///< near_distance
  double penalty[3 * PHN_MOST_COUPLED];             ///< H: the factor is that of K + R^T H R [N/m]
  std::int32_t n_constraints, n_all_constraints;    ///< rows of the tools that are held; with those of further tools
  double prescribed[3 * PHN_MOST_COUPLED], force[3 * PHN_MOST_COUPLED];  ///< d and f of the tools that are held
  double newton_force[3 * PHN_MOST_COUPLED];  ///< forces of the last step, however far from balance
  int status;                                 ///< of the last call of solve_body
  bool is_at_rest;                            ///< No tool was held since the start or a reset.
  /// Steps since the forces were last near balance, and starts from rest meanwhile.
  std::int32_t n_unbalanced_steps, n_restarts;
  double step_size;  ///< factor of the next step
  /// State of a cell for which the stiffness has its second derivatives.
  struct Cell {
    double displacement_gradient[9], pressure;
    float tangent[81];
  } * cells;
  float *cell_stiffness, *cell_stiffness_at_rest;  ///< sums over the cells, without the term of the pressures
  float* panel;                                    ///< rows of some cells
  double *squared_gradients, *stiffness_change;    ///< of each cell: square of its mode gradients; estimate
  double largest_modulus;                          ///< of the materials

  double* constraint_row(std::int64_t r) const { return constraint_rows + r * body->stride; }
  double* compliance_row(std::int64_t r) const { return compliance_rows + r * body->stride; }
};
