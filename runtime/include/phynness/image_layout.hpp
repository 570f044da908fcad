// Layout of an image (formats/image.md), as phn_image_open reads it and `phynness export` writes it. Numbers are
// little-endian. Every structure and table starts at a multiple of the size of its numbers. Offsets are bytes from the
// start of the image.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include <phynness/schema/bounds.hpp>
#include <phynness/schema/family.hpp>

namespace phynness::image {

inline constexpr uint32_t magic = 0x494e4850;  ///< "PHNI"
inline constexpr uint32_t version = 5;
inline constexpr uint32_t largest_table = 0x7fffffff;  ///< bytes of an image

using phynness::Family;

/// Components of displacements are clamped to this, in units of max_displacement.
inline constexpr double largest_displacement = schema::largest_modal_displacement;

/// Bounds of the numbers of an image. Within them no sum of an evaluation overflows.
inline constexpr uint32_t largest_count = 1u << 20;  ///< neurons or centers of one response
inline constexpr uint32_t largest_mode_count = schema::largest_mode_count;
template <class Real>
struct Bounds;
template <>
struct Bounds<float> {
  static constexpr float value = 1e12f, max_displacement = 1e6f;
};
template <>
struct Bounds<double> {
  static constexpr double value = 1e100, max_displacement = 1e90;
};
/// Bounds of computed values, in units of Bounds::value (totals, force and energy at rest), of a kernel at rest, of a
/// column's factor in a scaled table, and of a kernel's shape.
inline constexpr double largest_total = 1e6, largest_force_at_rest = 1e13, largest_energy_at_rest = 1e19;
inline constexpr double largest_at_rest = 1e7, largest_scale = 31, largest_shape = 1e6;

/// n values at offset `at`; n = 0: empty.
struct Table {
  uint32_t at, n;
};

/// Gaussian network with weights in units of its output: constant + sum_i w_i 2^-|factor (v - c_i)|^2, where the input
/// v is d and, in deformation networks, the coordinates of the output node. Centers are rows of the shared tables.
template <class Real, int n_inputs>
struct Network {
  Table displacement;     ///< uint16: row of Header::displacements, one per neuron
  Table output;           ///< uint16: row of Header::output_points; deformation only
  Table weight;           ///< Real: 3 per neuron
  Real factor[n_inputs];  ///< sqrt(log2 e) / (spread half_range)
  Real constant[3];
};

template <class Real>
struct RbfnResponse {
  static constexpr Family family = Family::rbfn;
  Network<Real, 3> force;
  Network<Real, 6> deformation;
};

template <class Real>
struct LinearResponse {
  static constexpr Family family = Family::linear;
  Real stiffness[6];     ///< xx xy xz yy yz zz [N/m]
  Table unit_responses;  ///< Real: n_output x 9
};

/// A matrix of 16-bit integers, row by row, with a factor for each column.
struct ScaledTable {
  Table scale;  ///< Real: n_columns
  Table entry;  ///< int16: n_rows n_columns
};

template <class Real>
struct ModalResponse {
  static constexpr Family family = Family::modal;
  Table center;       ///< uint16: row of Header::displacements, one per force center
  Table coefficient;  ///< Real: 3 per force center [N]
  Real shape;
  Real stiffness[6];                      ///< [N/m]
  Real total[3];                          ///< sum of the coefficients
  Real force_at_rest[3], energy_at_rest;  ///< added so that both vanish at d = 0 [N], [J / R]
  ScaledTable weights;                    ///< n_amplitude_centers + 3 rows, n_modes columns; empty: no deformation
  ScaledTable mixing;                     ///< n_shared rows
  Table near;                             ///< uint16: positions among the output nodes
  ScaledTable near_modes;                 ///< 3 n_near rows
};

template <class Real>
struct ActiveNode {
  Table prescribed;         ///< uint16: positions among the output nodes
  Table prescribed_weight;  ///< Real
  Table trained_depth;      ///< Real: n_directions [m]
  uint32_t incomplete;      ///< 0 or 1
  uint32_t response;        ///< offset of the family's response
};

/// Where tools can be between active nodes, in images of models of round tools, and the bounds of their forces' errors.
struct Surface {
  Table triangle;   ///< uint16: 6 each: its vertices, normals outward, then the triangles across from them; none: 65535
  Table vertex;     ///< VertexCorners
  Table point;      ///< Real: 3 per vertex [m]
  Table begin;      ///< uint32: n_active + n_linear + 1: first of each active node or linear point in the next two
  Table neighbour;  ///< uint16: a neighbour of the same kind
  Table slope;      ///< Real: 3 each [1/m]: part of the weight of the node that the neighbour takes
  Table rest_point;      ///< Real: n_linear x 3 [m]: points that answer as the body at rest
  Table rest_stiffness;  ///< Real: n_linear x 6: xx xy xz yy yz zz [N/m]
  Table bound;           ///< int16: n_active x displacements; empty: no bounds
  Table bound_scale;     ///< Real: n_active [N]
  Table between;         ///< Real: schema::n_coupled_terms, of one tool between nodes
};
/// The active nodes and, behind them, linear points between which a vertex lies, and two weights in parts of
/// schema::whole_weight, as in model.txt.
struct VertexCorners {
  uint16_t active[3], first, second;
};
inline constexpr uint16_t none = 0xffff;  ///< no triangle; the first active node of a fixed vertex
/// Largest number of active nodes around a place, and of neighbours of each.
inline constexpr uint32_t most_corners = 9, most_neighbours = schema::most_neighbours;
inline constexpr double largest_exponent = 1e3;  ///< of `between`

/// Where the model comes from, as phn_provenance. Strings end in zeros. Numbers are the halves of doubles, low and
/// high, in images of floats too, which are aligned to 4 bytes.
struct Provenance {
  char mesh_hash[20], physics_hash[20], element[20], reference[20];
  uint32_t shear_modulus_Pa[2], finer_mean[2], finer_p95[2], finer_tool_radius_m[2];
  int32_t finer_probes, finer_nodes, bound_reference;
  uint32_t surface;  ///< offset of a Surface; 0: none
  Table relaxation;  ///< uint32: halves of doubles as above: length [m], then g and tau [s] of each term; or empty
};

template <class Real>
struct Header {
  uint32_t magic, version, real_bytes;
  uint32_t bytes;     ///< of the whole image
  uint32_t checksum;  ///< of all words after this one
  Family family;
  uint32_t n_scratch;       ///< Reals
  uint32_t provenance;      ///< offset of a Provenance
  Table active_nodes;       ///< int32, ascending
  Table active_points;      ///< Real: n_active x 3 [m]
  Table active;             ///< ActiveNode<Real>
  Table output_nodes;       ///< int32, ascending
  Table output_points;      ///< Real: n_output x 3 [m]
  Table directions;         ///< Real: n_directions x 3
  Table displacements;      ///< Real: n x 3, [m], in family modal over max_displacement; n <= 65535
  Table amplitude_center;   ///< uint16: row of displacements; modal, as are the next two
  Table amplitude_at_rest;  ///< Real: subtracted so that amplitudes at d = 0 are exactly 0
  ScaledTable modes;        ///< 3 n_output rows, n_shared columns
  Real max_displacement;    ///< R [m]
  Real amplitude_shape;
};

/// Checksum of `n` words. Every step is invertible in the sum and in the word, so that a single damaged word is always
/// detected. The last two lines are a step of A. Appleby's MurmurHash3, which is in the public domain.
inline uint32_t checksum(const uint32_t* word, size_t n) {
  uint32_t sum = 0x9e3779b9u;
  for (size_t i = 0; i < n; ++i) {
    sum ^= word[i];
    sum = (sum << 13) | (sum >> 19);
    sum = sum * 5 + 0xe6546b64u;
  }
  return sum;
}

/// Words at the start that the checksum does not cover: magic, version, real_bytes, bytes and the checksum itself.
inline constexpr size_t n_unchecked_words = 5;

}  // namespace phynness::image
