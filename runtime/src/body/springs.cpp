// Springs of the tools (docs/theory.md, Near tools and Elsewhere). What two tools within a fraction of a radius
// prescribe, for example no tilt of the surface between them, hardly any force would resist or all forces would. Where
// no tool was probed, the modes of a body are too stiff.
#include "body/compliance.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// At one place the compliance of springs is this part of that of a tool.
constexpr double spring_part = 0.1;

/// Compliance that the modes lack acts between places up to this many radii apart.
constexpr double reach_of_lacking = 3;

/// Compliance of the spring between two tools over the mean of those of the tools alone. It ends smoothly at the
/// distance `near`. Tools at opposite faces of a thin part have none.
/// @param height  of both over the surface [m]
double part_between(double near, const BodyPlace& a, const BodyPlace& b, double height) {
  double square = height * height, facing = 0;
  for (int k = 0; k < 3; ++k) {
    square += (a.x[k] - b.x[k]) * (a.x[k] - b.x[k]);
    facing += a.normal[k] * b.normal[k];
  }
  const double left = 1 - square / (near * near);
  return left > 0 && facing > 0 ? spring_part * left * left * left * facing : 0;
}

/// Part of the lacking compliance that two places have in common: a positive definite function of both (Wendland 1995,
/// doi 10.1007/BF02123482), times another one, which is 0 at opposite faces.
double part_in_common(double radius, const BodyPlace& a, const BodyPlace& b) {
  double apart[3];
  for (int k = 0; k < 3; ++k) apart[k] = a.x[k] - b.x[k];
  const double sizes = length(a.normal) * length(b.normal);
  const double facing = sizes > 0 ? product(a.normal, b.normal, 3) / sizes : 0;
  const double far = length(apart) / (reach_of_lacking * radius), left = 1 - far;
  return left > 0 ? left * left * left * left * (4 * far + 1) * (1 + facing) / 2 : 0;
}

/// Adds R_a R_b times the part that they have in common: what forces at b move at a. @param sum  3 x 3
void add_lacking_between(const phn_body& body, const BodyPlace& a, const BodyPlace& b, double (*sum)[3]) {
  if (!a.lacks || !b.lacks) return;
  constexpr int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  const double part = &a == &b ? 1 : part_in_common(body.info.tool_radius_m, a, b);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) sum[i][k] += part * a.root[at[i][j]] * b.root[at[j][k]];
}

void add_node(const phn_body& body, double weight, std::int32_t node, BodyPlace& place) {
  for (int k = 0; k < 3; ++k) {
    place.x[k] += weight * body.info.points[3 * node + k];
    place.normal[k] += weight * body.normals[3 * node + k];
  }
  for (int k = 0; k < schema::n_of_root && body.lacking != nullptr; ++k) {
    place.root[k] += weight * body.lacking[static_cast<std::int64_t>(node) * body.lacking_stride + k];
    place.lacks = place.lacks || place.root[k] != 0;
  }
}

}  // namespace

BodyPlace place_of(const phn_body& body, std::int32_t node) {
  BodyPlace place = {};
  add_node(body, 1, node, place);
  return place;
}

BodyPlace place_of(const phn_body& body, const phn_tool& tool) {
  BodyPlace place = {};
  for (int c = 0; c < 3; ++c)
    if (tool.weights[c] > 0)
      add_node(body, tool.weights[c], find_sorted(body.info.nodes, body.info.n_nodes, tool.nodes[c]), place);
  return place;
}

void add_lacking(const phn_body_state& state, const BodyPlace& place, double* displacement) {
  for (std::int32_t t = 0; 3 * t < state.n_rows; ++t) {
    double compliance[3][3] = {};
    add_lacking_between(*state.body, place, state.places[t], compliance);
    for (int i = 0; i < 3; ++i) displacement[i] += product(compliance[i], state.force + 3 * t, 3);
  }
}

double near_distance(const phn_body& body) {
  if (body.info.tool_radius_m > 0) return schema::near_part * body.info.tool_radius_m;
  double sum = 0;
  for (std::int32_t i = 0; i < 3 * body.info.n_triangles; ++i) {
    const std::int32_t a = body.info.triangles[i], b = body.info.triangles[i % 3 == 2 ? i - 2 : i + 1];
    double edge[3];
    for (int k = 0; k < 3; ++k) edge[k] = body.info.points[3 * a + k] - body.info.points[3 * b + k];
    sum += length(edge);
  }
  return schema::near_part * sum / (3 * body.info.n_triangles);
}

void set_springs(phn_body_state& state, std::int32_t n_tools, const phn_tool* tools, const double* heights) {
  const phn_body& body = *state.body;
  state.has_springs = false;
  for (auto& row : state.near_springs) set_zero(row, 3 * most_body_tools);
  for (std::int32_t a = 0; a < n_tools; ++a) state.places[a] = place_of(body, tools[a]);
  for (std::int32_t a = 0; a < n_tools; ++a)
    for (std::int32_t b = 0; b < a; ++b) {
      const double part =
          part_between(state.near, state.places[a], state.places[b], heights != nullptr ? heights[a] + heights[b] : 0);
      if (!(part > 0)) continue;
      state.has_springs = true;
      for (int of = 0; of < 2; ++of) {
        double own[3][3];
        Compliance::alone(state, 3 * (of == 0 ? a : b), own);
        add_lacking_between(body, state.places[of == 0 ? a : b], state.places[of == 0 ? a : b], own);
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) {
            const double half = part / 2 * own[i][k];
            state.near_springs[3 * a + i][3 * a + k] += half;
            state.near_springs[3 * b + i][3 * b + k] += half;
            state.near_springs[3 * a + i][3 * b + k] -= half;
            state.near_springs[3 * b + i][3 * a + k] -= half;
          }
      }
    }
  memcpy(state.springs, state.near_springs, sizeof state.springs);
  for (std::int32_t a = 0; a < n_tools; ++a)
    for (std::int32_t b = 0; b < n_tools; ++b) {
      if (!state.places[a].lacks || !state.places[b].lacks) continue;
      state.has_springs = true;
      double compliance[3][3] = {};
      add_lacking_between(body, state.places[a], state.places[b], compliance);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) state.springs[3 * a + i][3 * b + k] += compliance[i][k];
    }
}

}  // namespace PHN_RUNTIME
