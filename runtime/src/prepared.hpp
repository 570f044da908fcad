// Modes of the nodes that were touched last, with the shared ones summed: u = (B P) a takes n_modes products for each
// row where B (P a) takes as many as there are shared modes.
#pragma once

#include "arena.hpp"
#include "model.hpp"

namespace phynness::runtime {

struct PreparedNode {
  std::int32_t active;    ///< position among the active nodes; -1: none
  std::int32_t n_blocks;  ///< blocks of rows that are ready; near_mode is as soon as there is one
  std::uint64_t touched;  ///< when
  double* near_mode;      ///< n_modes x 3 n_near
  float* modes;           ///< for every rows_per_block of the 3 n_output rows: those rows of each mode in turn
};

struct PreparedNodes {
  std::int32_t n;
  std::uint64_t now;
  PreparedNode* node;
};

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools);

inline std::int32_t block_count(const phn_model& model) {
  return (3 * model.n_output + rows_per_block - 1) / rows_per_block;
}

/// The entry of an active node, made a little readier if it was touched before; a new one, empty, takes the place of
/// the one that was not touched for longest. Null if summing beforehand gains nothing.
const PreparedNode* touch(const phn_model& model, PreparedNodes& prepared, std::int32_t active);

/// All of it at once.
void prepare(const phn_model& model, PreparedNodes& prepared, std::int32_t active);

}  // namespace phynness::runtime
