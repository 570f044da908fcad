// Geometry of the undeformed surface.
#pragma once

#include <cmath>

#include "core/evaluate.hpp"
#include "tools/vectors.hpp"

namespace PHN_RUNTIME {

inline const double* vertex_point(const phn_model& model, std::int32_t vertex) {
  return vertex < model.n_output ? model.output_points + 3 * static_cast<std::size_t>(vertex)
                                 : model.fixed_points + 3 * static_cast<std::size_t>(vertex - model.n_output);
}

inline std::int32_t vertex_node(const phn_model& model, std::int32_t vertex) {
  return vertex < model.n_output ? model.output_nodes[vertex] : model.fixed_nodes[vertex - model.n_output];
}

/// Twice the area times the unit normal.
inline Vector area_normal(const double* const corner[3]) {
  const Vector first = vector_at(corner[0]);
  return cross(vector_at(corner[1]) - first, vector_at(corner[2]) - first);
}

/// Gradients of the barycentric weights. @param normal  unit normal
inline void weight_gradients(const double* const corner[3], Vector gradient[3], Vector& normal) {
  normal = area_normal(corner);
  const double area = norm(normal);
  normal /= area;
  for (int k = 0; k < 3; ++k)
    gradient[k] = cross(normal, vector_at(corner[(k + 2) % 3]) - vector_at(corner[(k + 1) % 3])) / area;
}

/// @param weight, nearest  see nearest_weights
inline void nearest_on_triangle(const double* const corner[3], const double* x, double* weight, double* nearest,
                                double& distance) {
  double difference[3];
  nearest_weights(corner, x, weight);
  for (int k = 0; k < 3; ++k) {
    nearest[k] = weight[0] * corner[0][k] + weight[1] * corner[1][k] + weight[2] * corner[2][k];
    difference[k] = x[k] - nearest[k];
  }
  distance = length(difference);
}

}  // namespace PHN_RUNTIME
