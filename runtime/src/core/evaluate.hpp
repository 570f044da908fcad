// Evaluation of the responses of single nodes, and the working memory of a thread.
#pragma once

#include "core/arena.hpp"
#include "core/model.hpp"

namespace PHN_RUNTIME {

/// Parts of a deformation that do not depend on the displacement, stored for the nodes that were touched last. Family
/// modal stores the product B P of shared modes and mixing, because u = (B P) a takes n_modes products for each row,
/// but B (P a) takes as many as there are shared modes. Family rbfn stores Gaussians of the coordinates. A node for
/// which this saves time is always evaluated in this way, so that results do not depend on the nodes touched before.
struct PreparedNode {
  std::int32_t active;    ///< position among the active nodes; -1: none
  std::uint64_t touched;  ///< counter value of the last use
  // Family modal; null in others.
  double* near_mode;  ///< n_columns x 3 n_near
  float* modes;       ///< blocks of rows_per_block of the 3 n_output rows; in each block mode after mode
  // Family rbfn; null in others.
  double* gaussians;  ///< blocks of nodes_per_block output nodes; in each block neuron after neuron
};
struct PreparedNodes {
  std::int32_t n;
  std::uint64_t now;
  PreparedNode* node;
};

struct Coupling;

}  // namespace PHN_RUNTIME

struct phn_data {
  const phn_model* model;
  const phn_model* level;  ///< the level that is evaluated
  std::int32_t max_tools;
  double* scratch;  ///< model.n_scratch: quantities of a deformation that are common to all output nodes
  double* field;    ///< n_output x 3: the field of one tool
  PHN_RUNTIME::PreparedNodes prepared;
  PHN_RUNTIME::Coupling* coupling;
};

namespace PHN_RUNTIME {

/// Takes a phn_data from the arena, or its coupling (tools/coupled.hpp). @return null without memory
phn_data* make_data(Arena& arena, const phn_model& model, std::int32_t max_tools);
Coupling* make_coupling(Arena& arena, const phn_model& model, std::int32_t max_tools);

/// Position of `node` among the active nodes, or -1.
std::int32_t find_active(const phn_model& model, std::int32_t node);
/// Vertex of a mesh node: its position among the output nodes, or n_output + its position among the fixed nodes, or -1.
std::int32_t find_vertex(const phn_model& model, std::int32_t node);

/// The force is the gradient of the energy and the stiffness the derivative of the force, in families with an energy.
/// In all functions below `model` may be the model of any level. The force has the same bits with and without the
/// others.
/// @pre model.has_energy, or energy and stiffness are null
/// @param d          3 [m], finite
/// @param force      3 [N]
/// @param energy     the work from rest to d [J]; may be null
/// @param stiffness  3 x 3 [N/m]: derivative of the force; may be null
void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force,
                    double* energy = nullptr, double* stiffness = nullptr);

/// Whether the node has a deformation; a modal model may have forces only.
bool has_deformation(const phn_model& model, const ActiveNode& node);

/// A deformation is a product with the node's basis, which consists of amplitudes of modes, Gaussians of the
/// displacement d, or d itself.
std::int32_t basis_size(const phn_model& model, const ActiveNode& node);
/// @param basis    basis_size(node)
/// @param scratch  n_centers + 3 of the shared modes
void basis_of(const phn_model& model, const ActiveNode& node, const double* d, double* basis, double* scratch);
/// `share` times the constants plus the product with a basis, at all output nodes; nodes that the probe moves move by
/// d.
/// @pre has_deformation(model, node)
/// @param prepared  of this node, or null
/// @param scratch   model.n_scratch
/// @param field     n_output x 3 [m]
void field_of_basis(const phn_model& model, const ActiveNode& node, const PreparedNode* prepared, double share,
                    const double* d, const double* basis, double* scratch, double* field);

/// Field of one tool at all output nodes, including those that the probe itself moves.
/// @param active  position among the active nodes. @pre has_deformation(model, model.active[active])
/// @param data    provides working memory and prepared nodes
/// @param field   n_output x 3 [m]
void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d, double* field);

/// Number of rows of all modes, rounded up to whole blocks.
std::size_t prepared_rows(const phn_model& model);
/// The entry of an active node. A new entry replaces the least recently used one. Null if preparation saves no time for
/// this node. Entries always belong to the full level; a smaller level reads the first of their columns.
const PreparedNode* prepare(const phn_model& model, PreparedNodes& prepared, std::int32_t active);

/// Whether d is outside of the trained range. A linear model is exact at any depth up to the largest components.
bool outside(const phn_model& model, const ActiveNode& node, const double* d);
int warnings(const phn_model& model, const ActiveNode& node, const double* d);
/// Depth [m] of the trained range in the direction of d; for d = 0 the smallest positive trained depth.
double trained_depth(const phn_model& model, const ActiveNode& node, const double* d);
/// Bound [N] of the error of the force (formats/model.md, Bounds): in the direction nearest to d, linear between its
/// displacements. @pre node.bound is set; d is inside the trained range
double error_bound(const phn_model& model, const ActiveNode& node, const double* d);

/// |d| without intermediate overflow or underflow; infinite only if |d| itself exceeds the largest double.
double length(const double* d);

inline void zero(double* values, std::int32_t n) {
  for (std::int32_t i = 0; values != nullptr && i < n; ++i) values[i] = 0;
}
/// Sets the outputs of a refused call to zeros. They are written last because they may overlap an input.
inline int refuse(int status, double* outputs, std::int32_t n) {
  zero(outputs, n);
  return status;
}

}  // namespace PHN_RUNTIME
