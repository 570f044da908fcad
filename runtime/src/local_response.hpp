// What one active node does to a few points of the surface, and how that changes with its displacement.
#pragma once

#include "model.hpp"

namespace phynness::runtime {

/// The weighted sum of displacements of a few vertices under one active node displaced by d:
///   u(d) = constant + direct d + rows . basis(d),
/// with the node's own basis: amplitudes of modes, Gaussians of d, or d itself.
struct LocalResponse {
  double constant[3];
  double direct;  ///< of the vertices that the probe moves itself
  double* rows;   ///< 3 x basis_size(node)
};

/// The most that basis_size gives for any node of this family.
std::int32_t basis_size(const phn_model& model, const ActiveNode& node);

/// basis(d) and its gradient.
/// @param basis     basis_size(node)
/// @param gradient  3 x basis_size(node), row k by d_k [1/m]
/// @param scratch   4 (shared n_centers + 3) numbers
/// @return false where d is so far out that the response is cut and the gradient would be wrong
bool local_basis(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                 double* gradient, double* scratch);

/// @param vertices, weights  n of them; vertices as in phn_model::triangles, fixed ones do not move
void prepare_local(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
                   const double* weights, LocalResponse& local);

/// @param u  3 [m]; @param jacobian 3 x 3, du_i/dd_k at 3 i + k
void local_displacement(const LocalResponse& local, std::int32_t n_basis, const double* d, const double* basis,
                        const double* gradient, double* u, double* jacobian);

/// Derivative of the force by d, in every family; symmetric where the force has an energy.
/// @param stiffness  3 x 3 [N/m]
void force_jacobian(const phn_model& model, const ActiveNode& node, const double* d, double* stiffness);

}  // namespace phynness::runtime
