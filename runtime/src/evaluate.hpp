// Evaluation of the networks (11)-(12) and of linear responses; modal responses are in modal.hpp.
#pragma once

#include "coupled.hpp"
#include "model.hpp"
#include "prepared.hpp"

struct phn_data {
  const phn_model* model;
  const phn_model* level;  ///< what is evaluated
  std::int32_t max_tools;
  double* scratch;            ///< model.n_scratch: what a deformation computes once for all output nodes
  double* field;              ///< n_output x 3: the field of one tool
  double* nearest;            ///< n_output: distance to the nearest tool [m]
  double* weight_sum;         ///< n_output: sum of nearest / distance over the tools
  std::int32_t* asked_nodes;  ///< max_tools: of the deformation that is asked for,
  double* asked;              ///< and max_tools x 3 displacements, copied: its output may be their memory
  PHN_RUNTIME::Coupling coupling;
  PHN_RUNTIME::PreparedNodes prepared;
};

namespace PHN_RUNTIME {

/// Below, `model` is that of a level.
/// @param d  3 [m], finite; @param force 3 [N]
void evaluate_force(const phn_model& model, const ActiveNode& node, const double* d, double* force);

/// Energy and stiffness are derivatives of one another and of the force, where the family has them.
bool has_energy(const phn_model& model);
/// @pre has_energy(model)
/// @return work that led from rest to d [J]
double evaluate_energy(const phn_model& model, const ActiveNode& node, const double* d);
/// @pre has_energy(model)
/// @param stiffness  3 x 3 [N/m]: derivative of the force
void evaluate_stiffness(const phn_model& model, const ActiveNode& node, const double* d, double* stiffness);

/// Whether the node has a deformation: modal models may have forces only.
bool has_deformation(const phn_model& model, const ActiveNode& node);

/// Field of one tool at all output nodes, nodes moved by the probe itself included.
/// @param active  position among the active nodes. @pre has_deformation(model, model.active[active])
/// @param data    its scratch and prepared nodes are used; @param field n_output x 3 [m]
void evaluate_deformation(const phn_model& model, phn_data& data, std::int32_t active, const double* d, double* field);

/// Whether d is beyond what was trained; a linear model is exact at any depth, until components are cut.
bool outside(const phn_model& model, const ActiveNode& node, const double* d);

/// Depth trained in the direction nearest to d [m]; d = 0: the smallest positive one.
double trained_depth(const phn_model& model, const ActiveNode& node, const double* d);

/// |d| without overflow or underflow; infinite only where the value itself is beyond the largest double.
double length(const double* d);

}  // namespace PHN_RUNTIME
