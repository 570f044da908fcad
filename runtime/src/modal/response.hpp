// Response of a node of family modal: the functions listed in families.hpp, and its fields (formats/model.md, "Family
// `modal`"). Components of d are clamped to 1e6 max_displacement_m.
#pragma once

#include "local_response.hpp"

namespace PHN_RUNTIME {

void response_force(const ModalResponse& node, const double* d, double* force);
double response_energy(const ModalResponse& node, const double* d);
void response_derivatives(const ModalResponse& node, const double* d, double* force, double* energy, double* stiffness);

/// Values of a field at all output nodes, >= 0.
/// @param scratch  as model.n_scratch  @param out  n_output
void modal_field(const phn_model& model, const ModalResponse& node, std::int32_t field, const double* d,
                 double* scratch, double* out);

/// False for models without modes, which have forces only.
inline bool has_deformation(const ModalResponse& node) { return node.n_modes > 0; }
/// The basis consists of the amplitudes.
inline std::int32_t basis_size(const ModalResponse& node) { return node.n_modes; }
void response_basis(const phn_model& model, const ModalResponse& node, const double* d, double* basis, double* scratch);
void response_gradient(const phn_model& model, const ModalResponse& node, const double* d, double* basis,
                       double* gradient, double* scratch);
void response_field(const phn_model& model, const ModalResponse& node, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);

inline bool worth_preparing(const phn_model& model, const ModalResponse& node) {
  return worth_preparing(model.shared, node);
}
void prepare_response(const phn_model& model, const ModalResponse& node, PreparedNode& entry);

/// Sums modes over vertices. Vertices near the node have modes of their own; modes of other vertices are mixed from the
/// shared modes, which are summed first.
class ModeSum {
 public:
  ModeSum(const phn_model& model, const ModalResponse& node, double* shared)
      : _model(model), _node(node), _shared(shared) {
    for (std::int32_t k = 0; k < 3 * model.shared.n_modes; ++k) shared[k] = 0;
  }
  void add(std::int32_t output, const Matrix& map, LocalResponse& local);
  void finish(LocalResponse& local) const;

 private:
  const phn_model& _model;
  const ModalResponse& _node;
  double* _shared;  ///< n_modes x 3
  bool _mixes = false;
};
inline ModeSum vertex_sum(const phn_model& model, const ModalResponse& node, double* scratch) {
  return {model, node, scratch};
}

}  // namespace PHN_RUNTIME
