// Springs of the tools (docs/theory.md, Near tools and Elsewhere). The constraints of two tools within a fraction of a
// radius are nearly dependent, so that their forces would be undefined. Where no tool was probed, the modes of a body
// are too stiff.
#include "body/compliance.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Compliance of the spring between two tools at the same place, over the compliance of a tool.
constexpr double spring_part = 0.1;

/// Distance, in radii, up to which the residual compliances of two places are correlated.
constexpr double correlation_length = 3;

/// Compliance of the spring between two tools over the mean of the compliances of the single tools. It decreases
/// smoothly to 0 at the distance `near`. Tools at opposite faces of a thin part have no spring.
/// @param height  sum of their heights over the surface [m]
double spring_fraction(double near, const BodyPlace& a, const BodyPlace& b, double height) {
  double square = height * height, facing = 0;
  for (int k = 0; k < 3; ++k) {
    square += (a.x[k] - b.x[k]) * (a.x[k] - b.x[k]);
    facing += a.normal[k] * b.normal[k];
  }
  const double decay = 1 - square / (near * near);
  return decay > 0 && facing > 0 ? spring_part * decay * decay * decay * facing : 0;
}

/// Correlation of the residual compliances of two places: a positive definite function of both (Wendland 1995,
/// doi 10.1007/BF02123482), times another one, which is 0 at opposite faces.
double correlation(double radius, const BodyPlace& a, const BodyPlace& b) {
  double difference[3];
  for (int k = 0; k < 3; ++k) difference[k] = a.x[k] - b.x[k];
  const double sizes = length(a.normal) * length(b.normal);
  const double facing = sizes > 0 ? product(a.normal, b.normal, 3) / sizes : 0;
  const double far = length(difference) / (correlation_length * radius), decay = 1 - far;
  return decay > 0 ? decay * decay * decay * decay * (4 * far + 1) * (1 + facing) / 2 : 0;
}

/// Adds the residual compliance between two places, R_a R_b times their correlation: displacements at a by forces at b.
/// @param sum  3 x 3
void add_residual_compliance(const phn_body& body, const BodyPlace& a, const BodyPlace& b, double (*sum)[3]) {
  if (!a.has_residual_compliance || !b.has_residual_compliance) return;
  constexpr int entry[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  const double factor = &a == &b ? 1 : correlation(body.info.tool_radius_m, a, b);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j) sum[i][k] += factor * a.compliance_root[entry[i][j]] * b.compliance_root[entry[j][k]];
}

void add_node(const phn_body& body, double weight, std::int32_t node, BodyPlace& place) {
  for (int k = 0; k < 3; ++k) {
    place.x[k] += weight * body.info.points[3 * node + k];
    place.normal[k] += weight * body.normals[3 * node + k];
  }
  if (body.residual_compliance.n_rows == 0) return;
  const float* root = body.residual_compliance[node];
  for (int k = 0; k < schema::n_of_root; ++k) {
    place.compliance_root[k] += weight * root[k];
    place.has_residual_compliance = place.has_residual_compliance || place.compliance_root[k] != 0;
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

void add_residual_displacement(const phn_body_state& state, const BodyPlace& place, double* displacement) {
  for (std::int32_t t = 0; 3 * t < state.n_constraints; ++t) {
    double compliance[3][3] = {};
    add_residual_compliance(*state.body, place, state.places[t], compliance);
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
  for (auto& row : state.spring_compliance) set_zero(row, 3 * most_body_tools);
  for (bool& has_spring : state.has_spring) has_spring = false;
  for (std::int32_t a = 0; a < n_tools; ++a) state.places[a] = place_of(body, tools[a]);
  for (std::int32_t a = 0; a < n_tools; ++a)
    for (std::int32_t b = 0; b < a; ++b) {
      const double part = spring_fraction(state.near_m, state.places[a], state.places[b],
                                          heights != nullptr ? heights[a] + heights[b] : 0);
      if (!(part > 0)) continue;
      state.has_springs = state.has_spring[a] = state.has_spring[b] = true;
      const std::int32_t pair[] = {a, b};
      for (const std::int32_t t : pair) {
        double compliance[3][3];
        Compliance::of_single_tool(state, 3 * t, compliance);
        add_residual_compliance(body, state.places[t], state.places[t], compliance);
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k) {
            const double half = part / 2 * compliance[i][k];
            state.spring_compliance[3 * a + i][3 * a + k] += half;
            state.spring_compliance[3 * b + i][3 * b + k] += half;
            state.spring_compliance[3 * a + i][3 * b + k] -= half;
            state.spring_compliance[3 * b + i][3 * a + k] -= half;
          }
      }
    }
  for (std::int32_t a = 0; a < n_tools; ++a)
    for (std::int32_t b = 0; b < n_tools; ++b) {
      if (!state.places[a].has_residual_compliance || !state.places[b].has_residual_compliance) continue;
      state.has_springs = true;
      double compliance[3][3] = {};
      add_residual_compliance(body, state.places[a], state.places[b], compliance);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) state.spring_compliance[3 * a + i][3 * b + k] += compliance[i][k];
    }
}

}  // namespace PHN_RUNTIME
