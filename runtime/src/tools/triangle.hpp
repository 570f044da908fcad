// Geometry of the undeformed surface.
#pragma once

#include <cmath>

#include "core/evaluate.hpp"

namespace PHN_RUNTIME {

inline const double* vertex_point(const phn_model& model, std::int32_t vertex) {
  return vertex < model.n_output ? model.output_points + 3 * static_cast<std::size_t>(vertex)
                                 : model.fixed_points + 3 * static_cast<std::size_t>(vertex - model.n_output);
}

inline std::int32_t vertex_node(const phn_model& model, std::int32_t vertex) {
  return vertex < model.n_output ? model.output_nodes[vertex] : model.fixed_nodes[vertex - model.n_output];
}

inline void subtract(const double* a, const double* b, double* c) {
  for (int k = 0; k < 3; ++k) c[k] = a[k] - b[k];
}
inline void cross(const double* a, const double* b, double* c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}
inline double norm(const double* a) { return std::sqrt(dot(a, a)); }

/// Twice the area times the unit normal.
inline void area_normal(const double* const corner[3], double* normal) {
  double ab[3], ac[3];
  subtract(corner[1], corner[0], ab);
  subtract(corner[2], corner[0], ac);
  cross(ab, ac, normal);
}

/// Gradients of the barycentric weights. @param normal  unit normal
inline void weight_gradients(const double* const corner[3], double gradient[3][3], double* normal) {
  area_normal(corner, normal);
  const double area = norm(normal);
  for (int k = 0; k < 3; ++k) normal[k] /= area;
  for (int k = 0; k < 3; ++k) {
    double edge[3];
    subtract(corner[(k + 2) % 3], corner[(k + 1) % 3], edge);
    cross(normal, edge, gradient[k]);
    for (int l = 0; l < 3; ++l) gradient[k][l] /= area;
  }
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
