// Parts of a deformation that do not depend on the displacement, kept for the nodes that were touched last. Family
// modal: the product B P of shared modes and mixing, because u = (B P) a takes n_modes products for each row, but B (P
// a) takes as many as there are shared modes. Family rbfn: Gaussians of the coordinates. A node for which this saves
// time is always evaluated in this way, so that results do not depend on the nodes touched before.
#pragma once

#include "arena.hpp"
#include "model.hpp"

namespace PHN_RUNTIME {

struct PreparedNode {
  std::int32_t active;    ///< position among the active nodes; -1: none
  std::uint64_t touched;  ///< counter value of the last use
  // Family modal; null in others.
  double* near_mode;  ///< n_columns x 3 n_near
  float* modes;       ///< blocks of rows_per_block of the 3 n_output rows; in each block mode after mode
  // Family rbfn; null in others.
  Real* gaussians;  ///< blocks of nodes_per_block output nodes; in each block neuron after neuron
};

struct PreparedNodes {
  std::int32_t n;
  std::uint64_t now;
  PreparedNode* node;
};

/// Number of rows of all modes, rounded up to whole blocks.
std::size_t prepared_rows(const phn_model& model);

PreparedNodes lay_out_prepared(Arena& arena, const phn_model& model, std::int32_t max_tools);

/// The entry of an active node. A new entry replaces the least recently used one. Null if preparation saves no time for
/// this node. Entries always belong to the full level; a smaller level reads the first of their columns.
const PreparedNode* prepare(const phn_model& model, PreparedNodes& prepared, std::int32_t active);

}  // namespace PHN_RUNTIME
