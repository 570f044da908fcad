// The model in memory: a structure of arrays whose pointers all refer to the caller's memory.
#pragma once

#include <phynness/phynness.h>

#include <phynness/schema/bounds.hpp>
#include <phynness/schema/family.hpp>

#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/lookup.hpp"

namespace PHN_RUNTIME {

/// Neurons or centers per block, independent of the width of registers, so that sums are the same on every processor.
/// Arrays are padded to whole blocks with entries that contribute nothing.
inline constexpr std::int32_t block_size = 16;
constexpr std::int32_t whole_blocks(std::int32_t n) { return (n + block_size - 1) / block_size * block_size; }

using schema::largest_field_count;
static_assert(largest_field_count == PHN_MOST_FIELDS);
using schema::largest_level_count;

/// Gaussian network with scaled inputs and outputs, equations (11)-(12).
struct Network {
  std::int32_t n_neurons, n_inputs;  ///< n_inputs: 3 or 6
  double input_center[6], input_half_range[6];
  double output_center[3], output_half_range[3];
  double bias[3];
  double inverse_square_spread;  ///< 1 / r^2
  std::int32_t n_prepared;       ///< neurons of prepared tables: all of the full level, which begin with these
  const double* center[6];       ///< per input: n_neurons, scaled; whole blocks of the full level
  const double* weight[3];       ///< per output: n_neurons, padded with 0 to whole blocks
};

/// at = d / unit, with components clamped to `largest`. @param d, at  3
inline void clamp(const double* d, double unit, double largest, double* at) {
  for (int k = 0; k < 3; ++k) at[k] = clamp(d[k] / unit, largest);
}

/// Components of displacements of a linear model are clamped to this [m]. No coefficient is larger, so that products
/// and sums remain finite.
inline constexpr double largest_linear = schema::largest_linear_displacement;
/// Force = stiffness d; u = d_x U_x + d_y U_y + d_z U_z.
struct LinearResponse {
  double stiffness[6];             ///< xx xy xz yy yz zz [N/m]
  const double* unit_response[3];  ///< U per axis of d: n_output x 3 [m/m]
};

/// Components of displacements of a modal model are clamped to this, in max_displacement_m. With the bounds below and
/// those of formats/model.md (coefficients 1e100, tables 1e6, 1024 modes) forces and energies are below 1e300, and sums
/// of shared modes are below 1e37, so that no float overflows.
inline constexpr double largest_modal = schema::largest_modal_displacement;
inline constexpr double largest_center = 1e3;             ///< per component of a center, in max_displacement_m
inline constexpr double largest_max_displacement = 1e90;  ///< of a modal model [m]; its inverse is the smallest

/// Amplitudes of an active node and the modes that they multiply. Tables have 16-bit integers, row by row, and a factor
/// for each column.
struct ModalTables {
  std::int32_t n_modes, n_near;
  std::int32_t n_columns;         ///< modes of the full level, of which the first n_modes are used
  const double* weight_scale;     ///< n_modes [m]; for a field in units of its scale
  const std::int16_t* weight;     ///< of the amplitudes: n_centers + 3 rows (field: + 9) of n_modes
  const double* mixing_scale;     ///< n_columns
  const std::int16_t* mixing;     ///< shared n_modes rows of n_columns
  const std::int32_t* near;       ///< n_near positions among the output nodes
  const double* near_mode_scale;  ///< n_columns
  const std::int16_t* near_mode;  ///< 3 n_near rows (field: n_near) of n_columns
};

/// Force of family modal. With x = d / R, q(y) = sqrt(|y|^2 + shape^2) and b_i the coefficients:
///   force = K d + sum_i [Phi(x - c_i) - Phi(x) - Phi(c_i) + Phi(0)] b_i,  Phi(y) = q I + y y^T / q
/// The evaluation has one more center, at 0 with the coefficient -sum_i b_i, for the terms -Phi(x). Constants make
/// force and energy at rest exactly 0.
struct ModalForce {
  std::int32_t n_centers;
  double max_displacement;  ///< R [m]
  double shape;             ///< dimensionless
  double stiffness[6];      ///< K, xx xy xz yy yz zz [N/m]
  /// Terms in whole blocks: x, y and z of the centers over R, then of the coefficients [N]. After the centers follow
  /// the center at 0 with the coefficient -sum_i b_i, and zeros.
  const double* table;
  double force_at_rest[3];                  ///< added so that the sum of a force, in its order, is 0 at d = 0 [N]
  double slope_at_rest[3], energy_at_rest;  ///< the same for the energy and its gradient [N], [J / R]
};

/// Force, deformation (none if n_modes = 0) and fields of an active node of a modal model.
struct ModalResponse : ModalTables {
  ModalForce force;
  const ModalTables* fields;  ///< one for each field of the model
};

/// Rows of shared modes that are summed together; their sums fit into the registers of any processor with SIMD.
inline constexpr std::int32_t rows_per_block = 32;

/// Modes of deformations or of a field, shared by all nodes.
struct SharedTable {
  std::int32_t n_modes;
  std::int32_t components;  ///< rows per output node: 3; for a field 1
  std::int32_t n_rows;      ///< components * n_output
  const float* modes;       ///< blocks of rows_per_block rows; in each block mode after mode
};

/// The part of a field that all nodes of a modal model share.
struct SharedField : SharedTable {
  std::int32_t degree;
  double scale;
};

/// The part of the deformations that all nodes of a modal model share; fields have the same centers.
struct SharedModes : SharedTable {
  std::int32_t n_centers;
  double shape;
  const double* center[3];      ///< per component: n_centers, over max_displacement
  const double* basis_at_rest;  ///< n_centers; subtracted so that amplitudes at d = 0 are exactly 0
};

/// Whether a node has fewer modes than are shared; only then does summing them beforehand save time.
inline bool worth_preparing(const SharedModes& shared, const ModalResponse& node) {
  return node.n_modes > 0 && node.n_modes < shared.n_modes;
}

struct Networks {
  Network force, deformation;
};

/// In fields of linear points components of displacements are clamped to this [m], so that no float overflows.
inline constexpr double largest_at_rest = 1e15;
/// A point that was not probed: force = stiffness d; its modes are multiplied by d itself.
struct RestResponse : ModalTables {
  double stiffness[6];  ///< xx xy xz yy yz zz [N/m]
  double point[3];      ///< reference coordinates [m]
  std::int32_t output;  ///< position among the output nodes, or -1
};

struct ActiveNode {
  double point[3];                 ///< reference coordinates [m]
  std::int32_t output;             ///< position among the output nodes, or -1
  bool moves_mean;                 ///< the tool moves the weighted mean of these nodes by d, otherwise each by w d
  std::int32_t n_prescribed;       ///< number of output nodes that the tool moves
  const std::int32_t* prescribed;  ///< their positions among the output nodes
  const double* prescribed_weight;
  const double* trained_depth;  ///< n_directions [m]
  double least_depth;           ///< smallest trained depth
  const std::int16_t* bound;    ///< of the force's error, a row for each displacement; null: the model has none
  double bound_scale;           ///< [N]
  double bound_at_rest;         ///< size of the force at d = 0 [N], which is an error; 0 in families with an energy
  bool incomplete;
  // One of these is set: the first of a linear point, otherwise the one of the model's family. The others are null.
  const RestResponse* rest;
  const Networks* networks;
  const LinearResponse* linear;
  const ModalResponse* modal;
};

/// Errors as fractions; 0: not estimated.
struct LevelErrors {
  double force, displacement;
};

}  // namespace PHN_RUNTIME

/// Each level of a model is a phn_model. Levels share all arrays except centers of amplitudes and responses of the
/// active nodes. The last level is the full model, to which the others belong. Vertices of triangles are output nodes,
/// then, from n_output on, fixed ones.
struct phn_model : phn_info {
  const phn_model* full;     ///< the last level
  const phn_model* smaller;  ///< the other levels, n_levels - 1
  std::size_t bytes;         ///< of memory that the model occupies from here on
  PHN_RUNTIME::LevelErrors errors;
  phynness::Family kind;         ///< the family
  std::size_t n_scratch;         ///< doubles of working memory of a deformation; its basis is at the end
  std::size_t n_field_scratch;   ///< doubles of working memory of a field
  std::size_t n_basis;           ///< largest basis_size of a node
  std::size_t prepared_neurons;  ///< largest number of neurons of a deformation; 0 in families other than rbfn
  std::int32_t prepared_modes;   ///< largest number of modes of a node that is prepared (evaluate.hpp); modal only
  std::size_t prepared_near;     ///< largest number of entries of near_mode of such a node
  std::int32_t n_directions;
  const double* directions;  ///< n_directions x 3
  double first_increment;    ///< [m]: length of the first row of displacements
  std::int32_t n_displacements;
  const double* displacements;  ///< rows of 3; in family modal over max_displacement
  PHN_RUNTIME::SharedModes shared;
  PHN_RUNTIME::SharedField fields[PHN_RUNTIME::largest_field_count];
  PHN_RUNTIME::SharedTable rest_modes;    ///< of the linear points
  const PHN_RUNTIME::ActiveNode* active;  ///< n_active, then n_linear
  /// Coordinates of output nodes between these: triangles of positions, first those without linear points, and rows of
  /// output position (ascending), triangle, weight of its first corner, and part of the rest that its second has; these
  /// over schema::whole_weight.
  std::int32_t n_linear, n_probe_triangles, n_outer_triangles, n_covered;
  const std::int32_t *probe_triangles, *outer_triangles, *covered;
  const double* bound_between;  ///< of a tool between nodes, schema::n_coupled_terms; null: the model has no bounds
};

namespace PHN_RUNTIME {

class Arena;

/// Reads the whole text. Fills the model if the arena has memory, otherwise only counts bytes.
/// @param model       set to the model inside the arena, or null
/// @param wrong_byte  position of the first error, counted from 1; 0 for a valid text
/// @return a status of phynness.h
int load_model(const char* text, std::size_t length, Arena& arena, const phn_model** model, std::size_t& wrong_byte);

}  // namespace PHN_RUNTIME
