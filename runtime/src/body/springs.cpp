// Springs between tools that are near to each other (docs/theory.md, Near tools). What two tools within a fraction of a
// radius prescribe, for example no tilt of the surface between them, hardly any force would resist or all forces would.
#include "body/compliance.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Springs act between tools nearer than this part of a radius, or of a mean edge for tools that are points. At one
/// place their compliance is this part of that of a tool.
constexpr double near_part = 0.5, spring_part = 0.1;

/// Position at rest and unit normal there.
void find_place(const phn_body& body, const phn_tool& tool, double* x, double* normal) {
  set_zero(x, 3);
  set_zero(normal, 3);
  for (int c = 0; c < 3; ++c) {
    if (!(tool.weights[c] > 0)) continue;
    const std::int32_t node = find_sorted(body.info.nodes, body.info.n_nodes, tool.nodes[c]);
    for (int k = 0; k < 3; ++k) {
      x[k] += tool.weights[c] * body.info.points[3 * node + k];
      normal[k] += tool.weights[c] * body.normals[3 * node + k];
    }
  }
}

/// Compliance of the spring between two tools over the mean of those of the tools alone. It ends smoothly at the
/// distance `near`. Tools at opposite faces of a thin part have none.
/// @param height  of both over the surface [m]
double part_between(const phn_body& body, double near, const phn_tool& a, const phn_tool& b, double height) {
  double x[2][3], normal[2][3], square = height * height, facing = 0;
  find_place(body, a, x[0], normal[0]);
  find_place(body, b, x[1], normal[1]);
  for (int k = 0; k < 3; ++k) {
    square += (x[0][k] - x[1][k]) * (x[0][k] - x[1][k]);
    facing += normal[0][k] * normal[1][k];
  }
  const double left = 1 - square / (near * near);
  return left > 0 && facing > 0 ? spring_part * left * left * left * facing : 0;
}

}  // namespace

double near_distance(const phn_body& body) {
  if (body.info.tool_radius_m > 0) return near_part * body.info.tool_radius_m;
  double sum = 0;
  for (std::int32_t i = 0; i < 3 * body.info.n_triangles; ++i) {
    const std::int32_t a = body.info.triangles[i], b = body.info.triangles[i % 3 == 2 ? i - 2 : i + 1];
    double edge[3];
    for (int k = 0; k < 3; ++k) edge[k] = body.info.points[3 * a + k] - body.info.points[3 * b + k];
    sum += length(edge);
  }
  return near_part * sum / (3 * body.info.n_triangles);
}

void set_springs(phn_body_state& state, std::int32_t n_tools, const phn_tool* tools, const double* heights) {
  state.has_springs = false;
  for (auto& row : state.springs) set_zero(row, 3 * most_body_tools);
  for (std::int32_t a = 0; a < n_tools; ++a)
    for (std::int32_t b = 0; b < a; ++b) {
      const double part =
          part_between(*state.body, state.near, tools[a], tools[b], heights != nullptr ? heights[a] + heights[b] : 0);
      if (!(part > 0)) continue;
      state.has_springs = true;
      for (int of = 0; of < 2; ++of) {
        double own[3][3];
        Compliance::alone(state, 3 * (of == 0 ? a : b), own);
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) {
            const double half = part / 2 * own[i][k];
            state.springs[3 * a + i][3 * a + k] += half;
            state.springs[3 * b + i][3 * b + k] += half;
            state.springs[3 * a + i][3 * b + k] -= half;
            state.springs[3 * b + i][3 * a + k] -= half;
          }
      }
    }
}

}  // namespace PHN_RUNTIME
