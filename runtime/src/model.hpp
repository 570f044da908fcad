// The model in memory: structure of arrays, all pointers into the caller's memory.
#pragma once

#include <phynness/phynness.h>

#include <phynness/schema/bounds.hpp>
#include <phynness/schema/family.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "conservative.hpp"
#include "lookup.hpp"
#include "real.hpp"

namespace PHN_RUNTIME {

using schema::largest_field_count;
static_assert(largest_field_count == PHN_MOST_FIELDS);
using schema::largest_level_count;

/// Gaussian network on scaled inputs and outputs, (11)-(12).
struct Network {
  std::int32_t n_neurons, n_inputs;  ///< n_inputs: 3 or 6
  double input_center[6], input_half_range[6];
  double inverse_half_range[6];  ///< a division waits five times as long, which the last bit of a float does not show
  double output_center[3], output_half_range[3];
  double bias[3];
  double inverse_square_spread;  ///< 1 / r^2
  std::int32_t n_prepared;       ///< neurons of prepared tables: those of the full level, of which these are the first
  const Real* center[6];         ///< per input: n_neurons, scaled; whole blocks, as of the full level
  const Real* weight[3];         ///< per output: n_neurons, filled up with 0 to whole blocks
};

/// at = d / unit, components beyond `largest` cut there. @param d, at  3
inline void cut(const double* d, double unit, double largest, double* at) {
  for (int k = 0; k < 3; ++k) at[k] = cut(d[k] / unit, largest);
}

/// Displacements of a linear model are cut to this size per component [m], and no coefficient of one is
/// larger: their products and sums stay finite.
inline constexpr double largest_linear = schema::largest_linear_displacement;
/// Force = stiffness d; u = d_x U_x + d_y U_y + d_z U_z.
struct LinearResponse {
  double stiffness[6];             ///< xx xy xz yy yz zz [N/m]
  const double* unit_response[3];  ///< U per axis of d: n_output x 3 [m/m]
};

/// Displacements of a modal model are cut to this size per component, in max_displacement_m. With the bounds
/// below and those of formats/model.md (coefficients 1e100, tables 1e6, 1024 modes) forces and energies stay
/// below 1e300, and sums of shared modes below 1e37: no float overflows.
inline constexpr double largest_modal = schema::largest_modal_displacement;
inline constexpr double largest_center = 1e3;             ///< per component of a center, in max_displacement_m
inline constexpr double largest_max_displacement = 1e90;  ///< of a modal model, and one over its least [m]

/// Amplitudes of an active node and the modes that they multiply. Tables are 16-bit integers, row by row,
/// with a factor for each of their columns.
struct ModalTables {
  std::int32_t n_modes, n_near;
  std::int32_t n_columns;         ///< modes of the full level; the first n_modes of them count
  const double* weight_scale;     ///< n_modes [m]; of a field in its scale
  const std::int16_t* weight;     ///< of the amplitudes: n_centers + 3 rows of n_modes, of a field + 9
  const double* mixing_scale;     ///< n_columns
  const std::int16_t* mixing;     ///< shared n_modes rows of n_columns
  const std::int32_t* near;       ///< n_near positions among the output nodes
  const double* near_mode_scale;  ///< n_columns
  const std::int16_t* near_mode;  ///< 3 n_near rows of n_columns, of a field n_near
};

/// Forces of more centers read them from a table of their own, which costs 48 bytes a center (24 in float) and saves
/// half of the time; those of fewer gather them, so that small models stay small.
inline constexpr std::int32_t most_gathered = 2 * at_once - 1;

/// What the force sums, in whole blocks: x, y and z of the centers, those of the coefficients; after the centers the
/// one at 0 with the coefficient -sum_i b_i, and zeros.
struct ForceTable {
  const Real* centers;  ///< over max_displacement, and [N]; null: to be gathered
  double at_rest[3];    ///< added so that this sum, in its own order, vanishes at d = 0 [N]
};

/// Force, deformation (n_modes = 0: none) and fields of an active node of a modal model.
struct ModalResponse : ModalTables {
  Conservative<double> force;
  ForceTable force_table;
  const ModalTables* fields;  ///< one for each field of the model
};

/// Rows of shared modes that are summed together: few enough for the registers of any processor with SIMD.
inline constexpr std::int32_t rows_per_block = 32;

/// Modes that all nodes share, of deformations or of a field.
struct SharedTable {
  std::int32_t n_modes;
  std::int32_t components;  ///< rows of an output node: 3, of a field 1
  std::int32_t n_rows;      ///< components n_output
  const float* modes;       ///< for every rows_per_block of the rows: those rows of each mode in turn
};

/// What the nodes of a modal model share of a field.
struct SharedField : SharedTable {
  const char *name, *unit;  ///< end with 0
  std::int32_t degree;
  double scale;
};

/// What the deformations of a modal model share; fields have the same centers.
struct SharedModes : SharedTable {
  std::int32_t n_centers;
  double shape;
  const double* center[3];      ///< per component: n_centers, over max_displacement
  const double* basis_at_rest;  ///< n_centers: subtracted so that amplitudes at d = 0 are exactly 0
};

/// Whether a node has fewer modes than are shared: then summing those beforehand gains.
inline bool worth_preparing(const SharedModes& shared, const ModalResponse& node) {
  return node.n_modes > 0 && node.n_modes < shared.n_modes;
}

struct Networks {
  Network force, deformation;
};

struct ActiveNode {
  double point[3];                 ///< reference coordinates [m]
  std::int32_t output;             ///< position among the output nodes, or -1
  std::int32_t n_prescribed;       ///< output nodes that the probe moves itself
  const std::int32_t* prescribed;  ///< their positions among the output nodes
  const double* prescribed_weight;
  const double* trained_depth;  ///< n_directions [m]
  double least_depth;           ///< of these
  double fill_distance;         ///< of what was trained (trained.hpp), in max_displacement
  bool incomplete;
  // One of these, by the model's family; the others are null.
  const Networks* networks;
  const LinearResponse* linear;
  const ModalResponse* modal;
};

/// As fractions; 0: not estimated.
struct LevelErrors {
  double force, displacement;
};

}  // namespace PHN_RUNTIME

/// A level of a model is a phn_model of its own, made of the same arrays but for what the level has itself: centers of
/// amplitudes and the responses of the active nodes. The last level is the model that the others belong to.
struct phn_model {
  const phn_model* full;     ///< the last level
  const phn_model* smaller;  ///< the other levels, n_levels - 1
  std::size_t bytes;         ///< of the memory behind this that the model takes
  std::int32_t n_levels;
  PHN_RUNTIME::LevelErrors errors;
  phynness::Family family;
  const char *title, *mesh_hash;  ///< end with 0
  std::int32_t n_nodes, n_active, n_output, n_fixed, n_triangles, n_directions;
  std::size_t n_scratch;         ///< doubles that a deformation needs besides its result, its basis at the end
  std::size_t n_field_scratch;   ///< doubles that a field needs
  std::size_t n_basis;           ///< the largest basis_size of a node
  std::size_t prepared_neurons;  ///< most neurons of a deformation; 0 in other families than rbfn
  std::int32_t prepared_modes;   ///< most modes of a node that is worth preparing (prepared.hpp); 0 in other families
  std::size_t prepared_near;     ///< most entries of near_mode of such a node
  const std::int32_t *active_nodes, *output_nodes;
  const double* output_points;  ///< n_output x 3
  const std::int32_t* fixed_nodes;
  const double* fixed_points;     ///< n_fixed x 3
  const std::int32_t* triangles;  ///< n_triangles x 3 vertices: output nodes, then, from n_output on, fixed ones
  const double* directions;       ///< n_directions x 3
  double max_displacement;
  double first_increment;  ///< [m]: length of the first row of displacements
  std::int32_t n_displacements;
  const double* displacements;  ///< rows of 3; in family modal over max_displacement
  PHN_RUNTIME::SharedModes shared;
  std::int32_t n_fields;
  PHN_RUNTIME::SharedField fields[PHN_RUNTIME::largest_field_count];
  const PHN_RUNTIME::ActiveNode* active;
};

namespace PHN_RUNTIME {

class Arena;

/// Walks the whole text; fills the model if the arena has memory, otherwise only counts.
/// @param model  set to the model inside the arena, or null
/// @param wrong_byte  where a refused text is wrong, counted from 1; 0 for a good one
/// @return a status of phynness.h
int load_model(const char* text, std::size_t length, Arena& arena, const phn_model** model, std::size_t& wrong_byte);

/// Position of `node` among the active nodes, or -1.
std::int32_t find_active(const phn_model& model, std::int32_t node);
/// Vertex of a mesh node: its position among the output nodes, n_output + that among the fixed ones, or -1.
std::int32_t find_vertex(const phn_model& model, std::int32_t node);

}  // namespace PHN_RUNTIME
