// What one active node does to points of the surface and to the whole of it, as a product with the node's own
// basis: amplitudes of modes, Gaussians of its displacement d, or d itself.
#pragma once

#include "prepared.hpp"
#include "vectors.hpp"

namespace PHN_RUNTIME {

/// A sum of maps times displacements of a few vertices under one active node displaced by d: constant +
/// direct d + rows . basis(d).
struct LocalResponse {
  Vector constant;
  Matrix direct;  ///< of vertices that the probe moves itself
  double* rows;   ///< 3 x basis_size(node)
};

std::int32_t basis_size(const phn_model& model, const ActiveNode& node);

/// @param d  3 [m], of any size that is finite
/// @param basis  basis_size(node); @param scratch shared n_centers + 3
void basis_of(const phn_model& model, const ActiveNode& node, const double* d, double* basis, double* scratch);

/// Derivatives around rest, as differences over the first increment that was trained, forth and back: beside
/// a snap a derivative at 0 itself is that of the interpolation, not of the body.
/// @param gradient  3 x basis_size(node), row k by d_k [1/m]; @param scratch shared n_centers + 3
/// @param other     scratch, basis_size(node)
void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch,
                            double* other);

/// Values and derivatives at any d that is not cut. @param gradient  3 x basis_size(node)
/// @param scratch  3 (shared n_centers + 3)
void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch);

void clear_local(const phn_model& model, const ActiveNode& node, LocalResponse& local);

/// @param vertices, maps  n of them; vertices as in phn_model::triangles, fixed ones and -1 do
/// not move
/// @param scratch         3 shared n_modes, of networks basis_size(node)
void add_local(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
               const Matrix* maps, double* scratch, LocalResponse& local);

/// @return share constant + direct d + rows . basis [m]
Vector local_displacement(const LocalResponse& local, double share, const Vector& d, std::int32_t n_basis,
                          const double* basis);

/// The same for all output nodes. @pre has_deformation(model, node)
/// @param prepared  of this node, or null
/// @param scratch   model.n_scratch; @param field n_output x 3 [m]
void field_of_basis(const phn_model& model, const ActiveNode& node, const PreparedNode* prepared, double share,
                    const double* d, const double* basis, double* scratch, double* field);

/// How far forces at the trained depth, along the axes, are from the linear ones, over the latter, squared.
double curvature(const phn_model& model, const ActiveNode& node, const Matrix& stiffness);

/// Derivative of the force around rest, in the same way, symmetric and positive definite [N/m].
Matrix stiffness_at_rest(const phn_model& model, const ActiveNode& node);

}  // namespace PHN_RUNTIME
