// Response of a node of family linear: the functions listed in families.hpp.
#pragma once

#include "local_response.hpp"

namespace PHN_RUNTIME {

void response_force(const LinearResponse& linear, const double* d, double* force);
double response_energy(const LinearResponse& linear, const double* d);
void response_derivatives(const LinearResponse& linear, const double* d, double* force, double* energy,
                          double* stiffness);

inline bool has_deformation(const LinearResponse&) { return true; }
/// The basis is the displacement itself.
inline std::int32_t basis_size(const LinearResponse&) { return 3; }
void response_basis(const phn_model& model, const LinearResponse& linear, const double* d, double* basis,
                    double* scratch);
void response_gradient(const phn_model& model, const LinearResponse& linear, const double* d, double* basis,
                       double* gradient, double* scratch);
void response_field(const phn_model& model, const LinearResponse& linear, const PreparedNode* prepared, double share,
                    const double* basis, double* scratch, double* field);

inline bool worth_preparing(const phn_model&, const LinearResponse&) { return false; }
inline void prepare_response(const phn_model&, const LinearResponse&, PreparedNode&) {}

/// Sums unit responses over vertices.
class UnitSum {
 public:
  explicit UnitSum(const LinearResponse& linear) : _linear(linear) {}
  void add(std::int32_t output, const Matrix& map, LocalResponse& local) const;
  void finish(LocalResponse&) const {}

 private:
  const LinearResponse& _linear;
};
inline UnitSum vertex_sum(const phn_model&, const LinearResponse& linear, double*) { return UnitSum(linear); }

}  // namespace PHN_RUNTIME
