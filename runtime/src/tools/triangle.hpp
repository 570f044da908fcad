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

/// The point of a triangle nearest to x, by the regions of Ericson, Real-Time Collision Detection (2005), 5.1.5.
/// @param weight  barycentric, >= 0, sum 1
inline void nearest_on_triangle(const double* const corner[3], const double* x, double* weight, double* nearest,
                                double& distance) {
  const double *a = corner[0], *b = corner[1], *c = corner[2];
  double ab[3], ac[3], ax[3], bx[3], cx[3];
  for (int k = 0; k < 3; ++k) {
    ab[k] = b[k] - a[k];
    ac[k] = c[k] - a[k];
    ax[k] = x[k] - a[k];
    bx[k] = x[k] - b[k];
    cx[k] = x[k] - c[k];
  }
  const double d1 = dot(ab, ax), d2 = dot(ac, ax), d3 = dot(ab, bx), d4 = dot(ac, bx), d5 = dot(ab, cx),
               d6 = dot(ac, cx);
  const double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  double w[3] = {0, 0, 0};
  const auto share = [](double part, double rest) { return part + rest > 0 ? part / (part + rest) : 0; };
  if (d1 <= 0 && d2 <= 0) {
    w[0] = 1;
  } else if (d3 >= 0 && d4 <= d3) {
    w[1] = 1;
  } else if (d6 >= 0 && d5 <= d6) {
    w[2] = 1;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    w[1] = share(d1, -d3);
    w[0] = 1 - w[1];
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    w[2] = share(d2, -d6);
    w[0] = 1 - w[2];
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    w[2] = share(d4 - d3, d5 - d6);
    w[1] = 1 - w[2];
  } else {
    const double sum = va + vb + vc;
    w[1] = sum != 0 ? std::fmin(1.0, std::fmax(0.0, vb / sum)) : 0;
    w[2] = sum != 0 ? std::fmin(1 - w[1], std::fmax(0.0, vc / sum)) : 0;
    w[0] = 1 - w[1] - w[2];
  }
  double apart[3];
  for (int k = 0; k < 3; ++k) {
    weight[k] = w[k];
    nearest[k] = w[0] * a[k] + w[1] * b[k] + w[2] * c[k];
    apart[k] = x[k] - nearest[k];
  }
  distance = length(apart);
}

}  // namespace PHN_RUNTIME
