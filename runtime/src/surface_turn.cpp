#include "surface_turn.hpp"

#include "small_matrices.hpp"
#include "triangle.hpp"

namespace PHN_RUNTIME {
namespace {

/// One triangle's part of the rotation, times its area.
/// @param vertex  3; @param maps  9 for each. @return area [m^2]
double triangle_turn(const phn_model& model, const std::int32_t* vertex, double* maps) {
  const double* corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = vertex_point(model, vertex[k]);
  double normal[3], gradient[3][3];
  area_normal(corner, normal);
  const double area = norm(normal) / 2;
  if (!(area > 0)) return 0;
  weight_gradients(corner, gradient, normal);
  for (int i = 0; i < 3; ++i) {
    double tilt[3], spin[3];
    cross(gradient[i], normal, tilt);
    cross(normal, gradient[i], spin);
    for (int k = 0; k < 9; ++k)
      maps[9 * i + k] = area * (tilt[k / 3] * normal[k % 3] + normal[k / 3] * spin[k % 3] / 2);
  }
  return area;
}

/// Adds weight map to the entry of `vertex`, a new one if there is none. @pre turn.n < SurfaceTurn::most
void add_turn(SurfaceTurn& turn, std::int32_t vertex, double weight, const double* map) {
  std::int32_t at = 0;
  while (at < turn.n && turn.vertex[at] != vertex) ++at;
  if (at == turn.n) {
    turn.vertex[turn.n++] = vertex;
    for (int k = 0; k < 9; ++k) turn.map[9 * at + k] = 0;
  }
  add_scaled(weight, map, 9, turn.map + 9 * at);
}

}  // namespace

bool next_turn(const phn_model& model, std::int32_t n_vertices, const std::int32_t* vertex, const double* weight,
               SurfaceTurn& turn) {
  double maps[27];
  turn.n = 0;
  for (; turn.triangle < model.n_triangles && turn.n + 3 <= SurfaceTurn::most; ++turn.triangle) {
    const std::int32_t* corner = model.triangles + 3 * static_cast<std::size_t>(turn.triangle);
    double part = 0;
    for (std::int32_t v = 0; v < n_vertices; ++v) {
      if (corner[0] == vertex[v] || corner[1] == vertex[v] || corner[2] == vertex[v]) part += weight[v];
    }
    if (!(part > 0)) continue;
    const double area = triangle_turn(model, corner, maps);
    turn.area += part * area;
    for (int k = 0; k < 3 && area > 0; ++k) add_turn(turn, corner[k], part, maps + 9 * k);
  }
  return turn.n > 0;
}

void rotate(const double* v, bool backward, const double* x, double* turned) {
  double sideways[3];
  cross(v, x, sideways);
  const double square = dot(v, v), along = dot(v, x), sign = backward ? -1 : 1;
  for (int k = 0; k < 3; ++k)
    turned[k] = ((1 - square) * x[k] + 2 * along * v[k] + sign * 2 * sideways[k]) / (1 + square);
}

void rotation_gradient(const double* v, const double* g, const double* x, double* gradient) {
  double back[3], sideways[3];
  rotate(v, true, x, back);
  cross(x, g, sideways);
  const double square = dot(v, v), value = dot(g, back);
  for (int k = 0; k < 3; ++k)
    gradient[k] =
        2 * (dot(v, x) * g[k] + dot(g, v) * x[k] - dot(g, x) * v[k] - sideways[k] - value * v[k]) / (1 + square);
}

}  // namespace PHN_RUNTIME
