// Displacements of points of the surface by one active node, as products with the node's basis.
#pragma once

#include "core/evaluate.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

/// A sum of maps times displacements of a few vertices while one active node is displaced by d:
/// constant + direct d + rows . basis(d).
struct NodeField {
  Vector constant;
  Matrix direct;  ///< of vertices that the probe itself moves
  double* rows;   ///< 3 x basis_size(node)
};

/// Computes derivatives around rest as central differences over the first trained increment. Near a snap-through the
/// derivative at 0 itself would be a property of the interpolation and not of the body.
/// @param gradient  3 x basis_size(node), row k by d_k [1/m]
/// @param scratch   n_centers + 3 of the shared modes
/// @param other     working memory, basis_size(node)
void basis_gradient_at_rest(const phn_model& model, const ActiveNode& node, double* gradient, double* scratch,
                            double* other);

/// Values and derivatives at any d that is not clamped.
/// @param gradient  3 x basis_size(node)
/// @param scratch   3 (n_centers + 3) of the shared modes
void basis_and_gradient(const phn_model& model, const ActiveNode& node, const double* d, double* basis,
                        double* gradient, double* scratch);

void clear(const phn_model& model, const ActiveNode& node, NodeField& field);

/// @param vertices, maps  n each; vertices as in phn_model::triangles; fixed vertices and -1 do not move
/// @param scratch         3 n_modes of the shared modes; for networks basis_size(node)
void add_vertices(const phn_model& model, const ActiveNode& node, std::int32_t n, const std::int32_t* vertices,
                  const Matrix* maps, double* scratch, NodeField& field);

/// @return share constant + direct d + rows . basis [m]
Vector displacement_of(const NodeField& field, double share, const Vector& d, std::int32_t n_basis,
                       const double* basis);

/// Squared relative deviation of the forces at the trained depth, along the axes, from linear forces.
double nonlinearity(const phn_model& model, const ActiveNode& node, const Matrix& stiffness);

/// Derivative of the force around rest by central differences, over 0.3 of the first increment for round tools, made
/// symmetric and positive definite [N/m].
Matrix stiffness_at_rest(const phn_model& model, const ActiveNode& node);

}  // namespace PHN_RUNTIME
