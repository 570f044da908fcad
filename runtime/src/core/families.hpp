// The only place where the core distinguishes families. Each family has a folder with these functions for the type of a
// node's response; further functions for coupled tools are in tools/family_sums.hpp.
#pragma once

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {

/// Calls f with the node's response in the type of its family.
template <class Function>
PHN_INLINE decltype(auto) with_response(const phn_model& model, const ActiveNode& node, Function&& f) {
  if (node.rest != nullptr) return f(*node.rest);
  switch (model.kind) {
    case Family::rbfn:
      return f(*node.networks);
    case Family::linear:
      return f(*node.linear);
    case Family::modal:
      break;
  }
  return f(*node.modal);
}

// Force, alone or with any of energy and stiffness. Family rbfn has forces only.
void response_derivatives(const Networks& nets, const double* d, double* force, double*, double*);
void response_derivatives(const LinearResponse& linear, const double* d, double* force, double* energy,
                          double* stiffness);
void response_derivatives(const ModalResponse& node, const double* d, double* force, double* energy, double* stiffness);
void response_derivatives(const RestResponse& rest, const double* d, double* force, double* energy, double* stiffness);

// Whether the node has a deformation, and the size of its basis. A modal model without modes has forces only.
inline bool has_deformation(const Networks&) { return true; }
inline bool has_deformation(const LinearResponse&) { return true; }
inline bool has_deformation(const ModalTables& node) { return node.n_modes > 0; }

inline std::int32_t basis_size(const Networks& nets) { return nets.deformation.n_neurons; }
inline std::int32_t basis_size(const LinearResponse&) { return 3; }
inline std::int32_t basis_size(const ModalTables& node) { return node.n_modes; }

// The basis at a displacement, and the field of a basis.
void response_basis(const phn_model& model, const Networks& nets, const double* d, double* basis, double* scratch);
void response_basis(const phn_model& model, const LinearResponse& linear, const double* d, double* basis,
                    double* scratch);
void response_basis(const phn_model& model, const ModalResponse& node, const double* d, double* basis, double* scratch);
void response_basis(const phn_model& model, const RestResponse& rest, const double* d, double* basis, double* scratch);

void response_field(const phn_model& model, const Networks& nets, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);
void response_field(const phn_model& model, const LinearResponse& linear, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);
void response_field(const phn_model& model, const ModalResponse& node, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);
void response_field(const phn_model& model, const RestResponse& rest, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);

// Parts of a deformation that do not depend on the displacement.
inline bool worth_preparing(const phn_model&, const Networks&) { return true; }
inline bool worth_preparing(const phn_model&, const LinearResponse&) { return false; }
inline bool worth_preparing(const phn_model&, const RestResponse&) { return false; }
inline bool worth_preparing(const phn_model& model, const ModalResponse& node) {
  return worth_preparing(model.shared, node);
}
void prepare_response(const phn_model& model, const Networks& nets, PreparedNode& entry);
inline void prepare_response(const phn_model&, const LinearResponse&, PreparedNode&) {}
inline void prepare_response(const phn_model&, const RestResponse&, PreparedNode&) {}
void prepare_response(const phn_model& model, const ModalResponse& node, PreparedNode& entry);

/// Values of a field of family modal (formats/model.md, "Fields") at all output nodes, >= 0.
/// @param scratch  as model.n_scratch  @param out  n_output
void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out);

}  // namespace PHN_RUNTIME
