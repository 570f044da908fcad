// Evaluation of the networks (11)-(12) and of linear responses; modal responses are in modal.hpp.
#pragma once

#include "coupled.hpp"
#include "model.hpp"
#include "prepared.hpp"

struct phn_data {
  const phn_model* model;
  const phn_model* level;  ///< the level that is evaluated
  std::int32_t max_tools;
  double* scratch;            ///< model.n_scratch: quantities of a deformation that are common to all output nodes
  double* field;              ///< n_output x 3: the field of one tool
  double* nearest;            ///< n_output: distance to the nearest tool [m]
  double* weight_sum;         ///< n_output: sum of nearest / distance over the tools
  std::int32_t* asked_nodes;  ///< max_tools: copied arguments of a deformation, because its output may overlap them
  double* asked;              ///< max_tools x 3 displacements, copied for the same reason
  PHN_RUNTIME::Coupling coupling;
  PHN_RUNTIME::PreparedNodes prepared;
};

namespace PHN_RUNTIME {

/// In all functions below `model` may be the model of any level.
/// @param d      3 [m], finite
/// @param force  3 [N]
void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force);

/// Whether the family has an energy. The force is its gradient and the stiffness the derivative of the force.
bool has_energy(const phn_model& model);
/// @pre has_energy(model)
/// @return the work from rest to d [J]
double evaluate_energy(const phn_model& model, const ActiveNode& node, const double* d);
/// The same bits of the force, and with it energy and stiffness.
/// @pre has_energy(model)
/// @param energy     may be null
/// @param stiffness  3 x 3 [N/m]: derivative of the force; may be null
void evaluate_derivatives(const phn_model& model, const ActiveNode& node, const double* d, double* force,
                          double* energy, double* stiffness);

/// Whether the node has a deformation; a modal model may have forces only.
bool has_deformation(const phn_model& model, const ActiveNode& node);

/// Field of one tool at all output nodes, including those that the probe itself moves.
/// @param active  position among the active nodes. @pre has_deformation(model, model.active[active])
/// @param data    provides working memory and prepared nodes
/// @param field   n_output x 3 [m]
void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d, double* field);

/// Whether d is outside of the trained range. A linear model is exact at any depth up to the largest components.
bool outside(const phn_model& model, const ActiveNode& node, const double* d);

/// Depth [m] of the trained range in the direction of d; for d = 0 the smallest positive trained depth.
double trained_depth(const phn_model& model, const ActiveNode& node, const double* d);

/// |d| without intermediate overflow or underflow; infinite only if |d| itself exceeds the largest double.
double length(const double* d);

}  // namespace PHN_RUNTIME
