// Response of a node of family rbfn: the functions listed in families.hpp.
#pragma once

#include "local_response.hpp"

namespace PHN_RUNTIME {

void response_force(const Networks& nets, const double* d, double* force);
/// The family has no energy and no stiffness.
inline double response_energy(const Networks&, const double*) { return 0; }
inline void response_derivatives(const Networks& nets, const double* d, double* force, double*, double*) {
  response_force(nets, d, force);
}

inline bool has_deformation(const Networks&) { return true; }
inline std::int32_t basis_size(const Networks& nets) { return nets.deformation.n_neurons; }
void response_basis(const phn_model& model, const Networks& nets, const double* d, double* basis, double* scratch);
void response_gradient(const phn_model& model, const Networks& nets, const double* d, double* basis, double* gradient,
                       double* scratch);
void response_field(const phn_model& model, const Networks& nets, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);

inline bool worth_preparing(const phn_model&, const Networks&) { return true; }
void prepare_response(const phn_model& model, const Networks& nets, PreparedNode& entry);

/// Sums Gaussians over vertices.
class NetworkSum {
 public:
  NetworkSum(const phn_model& model, const Networks& nets, double* scratch)
      : _model(model), _net(nets.deformation), _gaussian(scratch) {}
  void add(std::int32_t output, const Matrix& map, LocalResponse& local) const;
  void finish(LocalResponse&) const {}

 private:
  const phn_model& _model;
  const Network& _net;
  double* _gaussian;  ///< n_neurons
};
inline NetworkSum vertex_sum(const phn_model& model, const Networks& nets, double* scratch) {
  return {model, nets, scratch};
}

}  // namespace PHN_RUNTIME
