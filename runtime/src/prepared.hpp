// What does not depend on the displacement, of the nodes that were touched last. Family modal: modes with the shared
// ones summed, as u = (B P) a takes n_modes products for each row where B (P a) takes as many as there are shared
// modes. Family rbfn: Gaussians of the coordinates. A node that is worth it is always evaluated in this way: results do
// not depend on what was touched before.
#pragma once

#include "arena.hpp"
#include "model.hpp"

namespace PHN_RUNTIME {

struct PreparedNode {
  std::int32_t active;    ///< position among the active nodes; -1: none
  std::uint64_t touched;  ///< when
  // Family modal; null in others.
  double* near_mode;  ///< n_columns x 3 n_near
  float* modes;       ///< for every rows_per_block of the 3 n_output rows: those rows of each mode in turn
  // Family rbfn; null in others.
  Real* gaussians;  ///< for every nodes_per_block of the output nodes: those of each neuron in turn
};

struct PreparedNodes {
  std::int32_t n;
  std::uint64_t now;
  PreparedNode* node;
};

/// Rows of all modes, whole blocks.
std::size_t prepared_rows(const phn_model& model);

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools);

/// The entry of an active node; a new one takes the place of the one that was not touched for longest. Null if summing
/// beforehand gains nothing. Entries are those of the full level, whatever the level of `model`: a smaller one reads
/// the first of their columns.
const PreparedNode* prepare(const phn_model& model, PreparedNodes& prepared, std::int32_t active);

}  // namespace PHN_RUNTIME
