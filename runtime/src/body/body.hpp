// A reduced body in memory, the tools on it, and its state (docs/theory.md, Reduced body).
#pragma once

#include <phynness/phynness_body.h>

#include <phynness/schema/body_grammar.hpp>
#include <phynness/schema/body_laws.hpp>

#include "core/arena.hpp"
#include "core/model.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// The numbers of the law in a part of a body.
struct BodyMaterial {
  double parameters[phynness::schema::largest_parameter_count];
  double bulk;     ///< of the shape: bulk/2 g^2
  double modulus;  ///< largest second derivative of the shape at rest; 0 if the law is not defined
};

}  // namespace PHN_RUNTIME

/// Rows of modes and of pressures are padded with zeros to whole blocks.
struct phn_body {
  phn_body_contents info;
  const PHN_RUNTIME::BodyLaw* law;
  const PHN_RUNTIME::BodyMaterial* materials;  ///< n_materials, the first is that of cells in no region
  const std::int32_t* material_of_cell;        ///< null: the first one
  std::int32_t n_materials;
  std::int32_t stride;  ///< of rows of modes
  std::int32_t pressure_stride;
  const std::int32_t* kinds;   ///< of nodes
  const std::int32_t* across;  ///< n_triangles x 3: the triangle at the edge from corner k to k + 1; -1: none
  const double* normals;       ///< unit normals of nodes
  const float* modes;          ///< 3 n_nodes rows
  const double *shear, *bulk_of_cell;
  const float* gradients;  ///< 9 n_cells rows
  /// n_modes rows: second derivatives of the shape's energy at rest, of the cells and what they lack; null: not known.
  const float *cells_at_rest, *lack_at_rest;
  std::int32_t n_pressed;           ///< cells with a pressure
  const std::int32_t* pressed_row;  ///< of the cells: their rows of `pressures`, ascending; -1: none
  const float* pressures;           ///< n_pressed rows
  const float* lacking;             ///< n_nodes rows: roots of the compliance that the modes lack there; null: none
  std::int32_t lacking_stride;
  const double* bounds;  ///< coefficients of core/bound.hpp, n_coupled_kinds x n_coupled_terms; null: none

  const PHN_RUNTIME::BodyMaterial& material(std::int32_t cell) const {
    return materials[material_of_cell != nullptr ? material_of_cell[cell] : 0];
  }
};

namespace PHN_RUNTIME {

/// @return a status of phynness.h; *result is null on failure and when only counting
int load_body(const char* text, std::size_t length, Arena& arena, const phn_body** result, std::size_t& wrong_byte);

/// Whether a tool may be at a node: that of a probe is near, or it is known what the modes lack.
inline bool is_touchable(const phn_body& body, std::int32_t node) {
  return body.kinds[node] == phynness::schema::body_node_touchable ||
         (body.kinds[node] == phynness::schema::body_node_moves && body.lacking != nullptr);
}

/// A place of the surface.
struct BodyPlace {
  double x[3], normal[3];                    ///< at rest
  double root[phynness::schema::n_of_root];  ///< of the compliance that the modes lack
  bool lacks;                                ///< the root is not zero
};

/// Working memory of the means below.
struct ToolScratch {
  double* weight;                   ///< per node; zeros between calls
  std::int32_t *touched, *reached;  ///< nodes with a weight; triangles
  char* taken;                      ///< per triangle; zeros between calls
};

/// Mean displacements of the modes under a tool: three rows. @return PHN_OK, PHN_WARNING_OUTSIDE or an error
int means_of_modes(phn_body_state& state, const phn_tool& tool, double* rows);

/// Distance from which on there is no spring between two tools [m].
double near_distance(const phn_body& body);

/// state.springs and what belongs to them, from the places of the tools and their compliance at rest.
/// @pre state.rows are those of the tools
/// @param heights  of the tools over the surface [m]; null: zeros
void set_springs(phn_body_state& state, std::int32_t n_tools, const phn_tool* tools, const double* heights);

/// Where a next step is larger than this part of the deformation, forces are those of the call before.
inline constexpr double far_from_balance = 0.1;

/// A state in an arena, not yet at rest; null: counting, or no memory.
phn_body_state* lay_out_state(Arena& arena, const phn_body& body, std::int32_t max_tools);
/// @return a status of phynness.h
int start_state(phn_body_state& state);

/// phn_body_force with tools that are not held, behind those that are: no force acts on them, but they have springs.
/// @param n_tools   all of them, of which n_held are held
/// @param held_by   3 n_held forces [N], in an array of zeros for PHN_MOST_COUPLED tools
/// @return a status of phynness.h; outputs are then undefined where it is an error
int press_body(phn_body_state& state, std::int32_t n_held, std::int32_t n_tools, const phn_tool* tools,
               const double* heights, std::int32_t steps, double* held_by, phn_body_report& made);

/// Adds what the forces of the last press move at a place beside what they move in the modes [m].
void add_lacking(const phn_body_state& state, const BodyPlace& place, double* displacement);
/// The place of a node, or of a tool.
BodyPlace place_of(const phn_body& body, std::int32_t node);
BodyPlace place_of(const phn_body& body, const phn_tool& tool);

/// Dense loops, for several instruction sets (core/kernels.hpp). Strides and numbers of columns are whole blocks.
struct BodyKernels {
  const char* name;
  /// out[r] = rows[r] . x
  void (*times)(const float* rows, std::int64_t n, std::int32_t stride, const double* x, double* out);
  /// out += sum_r factor[r] rows[r]
  void (*add)(const float* rows, std::int64_t n, std::int32_t stride, const double* factor, double* out);
  /// Upper triangle, in blocks, of out += a^T b. @param n  rows of a and b
  void (*add_products)(const float* a, const float* b, std::int64_t n, std::int32_t stride, float* out);
  /// out += a^T b, a_stride x stride
  void (*multiply)(const float* a, std::int32_t a_stride, const float* b, std::int64_t n, std::int32_t stride,
                   float* out);
  /// out = factor . rows, of the nine rows of a cell
  void (*mix)(const float* rows, std::int32_t stride, const float* factor, float* out);
  /// Cholesky factor in place of the upper triangle; diagonals become their inverses. @return whether it is definite
  bool (*factorize)(float* a, std::int32_t n, std::int32_t stride);
  /// x = A^-1 x
  void (*solve)(const float* factor, std::int32_t n, std::int32_t stride, double* x);
};
const BodyKernels* body_kernels(int set);
const BodyKernels& best_body_kernels();

}  // namespace PHN_RUNTIME

struct phn_body_state {
  const phn_body* body;
  const PHN_RUNTIME::BodyKernels* kernels;
  std::int32_t max_tools;
  PHN_RUNTIME::ToolScratch scratch;
  /// A state: amplitudes of the modes, and of its energy the gradient, and the sums b of the pressures.
  struct Point {
    double *q, *forces, *sums, *strain, energy;
    float* changes;  ///< v dg/dq of the cells with a pressure
  } at, trial;
  /// b as the last step expected it. With it in the next stiffness, and not with b, Newton's method is that of the
  /// mixed problem: b is off by the square of a step, times a bulk modulus.
  double* expected;
  double* pressure_at;   ///< of the cells with a pressure: products with b
  double rounding;       ///< of energies near rest [J]
  double *rows, *moved;  ///< 3 max_tools rows: means of the modes under the tools; products with the compliance
  double *alone, *step;
  double *of_cells, *lacking;      ///< products of these derivatives with q
  float *factor, *factor_at_rest;  ///< of the stiffness
  float* bulk_rows;                ///< db/dq of the state of the factor, n_pressures rows
  /// Springs of the tools: how far they stretch, in each row, by unit forces of all [m/N]; and those of them between
  /// near tools.
  double springs[3 * PHN_MOST_COUPLED][3 * PHN_MOST_COUPLED], near_springs[3 * PHN_MOST_COUPLED][3 * PHN_MOST_COUPLED];
  bool has_springs;
  PHN_RUNTIME::BodyPlace places[PHN_MOST_COUPLED];  ///< of the tools
  double near;                                      ///< near_distance
  double held[3 * PHN_MOST_COUPLED];  ///< multiples of the squares of what the tools displace that the factor has [N/m]
  std::int32_t n_rows, n_all_rows;    ///< of the tools that are held; and of those behind them
  double wanted[3 * PHN_MOST_COUPLED], force[3 * PHN_MOST_COUPLED];  ///< of these tools
  double solved[3 * PHN_MOST_COUPLED];  ///< forces of the last step, however far from balance
  int status;                           ///< of the last press
  bool is_at_rest;                      ///< no tool was held since the start or a release
  std::int32_t n_far, n_restarts;       ///< steps since the forces were last near balance; starts from rest meanwhile
  double part;                          ///< of the next step
  /// What the stiffness has of a cell: its strain, pressure and second derivatives.
  struct Cell {
    double strain[9], pressure;
    float tangent[81];
  } * cells;
  float *sum, *sum_at_rest, *panel;  ///< of the cells, without that of b; rows of some of them
  double *size_of_rows, *changed;    ///< of the cells: squares of their rows; how much they changed
  double modulus;                    ///< largest one of the materials
};
