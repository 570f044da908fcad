#include "tools/surface_turn.hpp"

#include "tools/triangle.hpp"

namespace PHN_RUNTIME {
namespace {

/// One triangle's part of the rotation, times its area.
/// @param vertex, maps  3. @return area [m^2]
double triangle_rotation(const phn_model& model, const std::int32_t* vertex, Matrix* maps) {
  const double* corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = vertex_point(model, vertex[k]);
  const double area = norm(area_normal(corner)) / 2;
  if (!(area > 0)) return 0;
  Vector normal, gradient[3];
  weight_gradients(corner, gradient, normal);
  for (int i = 0; i < 3; ++i) {
    const Vector tilt = cross(gradient[i], normal), spin = cross(normal, gradient[i]);
    for (int k = 0; k < 9; ++k) maps[i].a[k] = area * (tilt[k / 3] * normal[k % 3] + normal[k / 3] * spin[k % 3] / 2);
  }
  return area;
}

/// Adds weight * map to the entry of `vertex`, which is created if missing. @pre rotation.n < SurfaceRotation::most
void add_rotation(SurfaceRotation& rotation, std::int32_t vertex, double weight, const Matrix& map) {
  std::int32_t at = 0;
  while (at < rotation.n && rotation.vertex[at] != vertex) ++at;
  if (at == rotation.n) {
    rotation.vertex[rotation.n++] = vertex;
    rotation.map[at] = {};
  }
  rotation.map[at] += weight * map;
}

}  // namespace

void find_rotation(const phn_model& model, std::int32_t n_vertices, const std::int32_t* vertex, const double* weight,
                   SurfaceRotation& rotation) {
  Matrix maps[3];
  rotation.n = 0;
  rotation.area = 0;
  for (std::int32_t t = 0; t < model.n_triangles && rotation.n + 3 <= SurfaceRotation::most; ++t) {
    const std::int32_t* corner = model.triangles + 3 * static_cast<std::size_t>(t);
    double part = 0;
    for (std::int32_t v = 0; v < n_vertices; ++v)
      if (corner[0] == vertex[v] || corner[1] == vertex[v] || corner[2] == vertex[v]) part += weight[v];
    if (!(part > 0)) continue;
    const double area = triangle_rotation(model, corner, maps);
    rotation.area += part * area;
    for (int k = 0; k < 3 && area > 0; ++k) add_rotation(rotation, corner[k], part, maps[k]);
  }
}

namespace {

Vector rotate(const Vector& v, double sign, const Vector& x) {
  const double square = dot(v, v), along = dot(v, x);
  return ((1 - square) * x + (2 * along) * v + (sign * 2) * cross(v, x)) / (1 + square);
}

}  // namespace

Vector rotated(const Vector& v, const Vector& x) { return rotate(v, 1, x); }
Vector rotated_back(const Vector& v, const Vector& x) { return rotate(v, -1, x); }

Vector rotation_gradient(const Vector& v, const Vector& g, const Vector& x) {
  const double square = dot(v, v), value = dot(g, rotated_back(v, x));
  const Vector sum = dot(v, x) * g + dot(g, v) * x - dot(g, x) * v - cross(x, g) - value * v;
  return (2 * sum) / (1 + square);
}

}  // namespace PHN_RUNTIME
