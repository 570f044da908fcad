// The mean displacement under a round tool anywhere on the surface (docs/decisions/round-tool.md), as
// formats/include/phynness/formats/tool.hpp defines it, by integrals in closed form.

#include "body/body.hpp"

namespace PHN_RUNTIME {
namespace {

/// Tolerance of the sum of barycentric weights, and the smallest weight that counts.
constexpr double weight_slack = 1e-6, no_weight = 1e-12;

/// Area and first moments, in a plane with the origin in the middle of a disc.
struct Moments {
  double area = 0, x = 0, y = 0;
};

/// The angle from a to b of plane vectors, between -pi and pi.
double angle_between(const double* a, const double* b, double lengths) {
  const double across = a[0] * b[1] - a[1] * b[0], along = a[0] * b[0] + a[1] * b[1];
  if (!(lengths + along > 1e-15 * lengths)) return across < 0 ? -3.14159265358979323846 : 3.14159265358979323846;
  double t = across / (lengths + along);  // of half the angle; halved until atan(t) is its series
  int doublings = 1;
  for (; t > 0.1 || t < -0.1; ++doublings) t /= 1 + std::sqrt(1 + t * t);
  double sum = 0;
  for (int k = 15; k >= 1; k -= 2) sum = 1.0 / k - t * t * sum;
  for (sum *= t; doublings > 0; --doublings) sum *= 2;
  return sum;
}

void add_sector(double radius, const double* a, const double* b, Moments& sum) {
  const double length_a = std::sqrt(a[0] * a[0] + a[1] * a[1]), length_b = std::sqrt(b[0] * b[0] + b[1] * b[1]);
  if (!(length_a > 0 && length_b > 0)) return;
  const double angle = angle_between(a, b, length_a * length_b);
  const double third = radius * radius * radius / 3;
  sum.area += radius * radius * angle / 2;
  sum.x += third * (b[1] / length_b - a[1] / length_a);
  sum.y += third * (a[0] / length_a - b[0] / length_b);
}

void add_triangle(const double* a, const double* b, Moments& sum) {
  const double area = (a[0] * b[1] - a[1] * b[0]) / 2;
  sum.area += area;
  sum.x += area * (a[0] + b[0]) / 3;
  sum.y += area * (a[1] + b[1]) / 3;
}

/// Adds the part of the disc in the triangle of its middle, a and b, with the sign of their order. The sum over the
/// edges of a polygon is the part of the disc inside.
void add_edge(double radius, const double* a, const double* b, Moments& sum) {
  const double d[2] = {b[0] - a[0], b[1] - a[1]};
  const double dd = d[0] * d[0] + d[1] * d[1], ad = a[0] * d[0] + a[1] * d[1];
  const double root = ad * ad - dd * (a[0] * a[0] + a[1] * a[1] - radius * radius);
  double from = 1, to = 1;  // the edge is inside of the disc between these
  if (dd > 0 && root > 0) {
    from = std::fmin(std::fmax((-ad - std::sqrt(root)) / dd, 0), 1);
    to = std::fmin(std::fmax((-ad + std::sqrt(root)) / dd, 0), 1);
  }
  const double p[2] = {a[0] + from * d[0], a[1] + from * d[1]}, q[2] = {a[0] + to * d[0], a[1] + to * d[1]};
  if (from > 0) add_sector(radius, a, p, sum);
  if (to > from) add_triangle(p, q, sum);
  if (to < 1) add_sector(radius, q, b, sum);
}

/// The squared distance from x to the edge from a to b.
double distance2_to_edge(const Vector& x, const Vector& a, const Vector& b) {
  const Vector along = b - a;
  const double square = dot(along, along);
  const double t = square > 0 ? std::fmin(std::fmax(dot(x - a, along) / square, 0), 1) : 0;
  const Vector apart = x - a - t * along;
  return dot(apart, apart);
}

/// Integrals of the linear functions of the corners over the part of a triangle within the radius around x.
void integrate(const Vector (&corner)[3], const Vector& x, double radius, const Vector& normal, double out[3]) {
  const double height = dot(x - corner[0], normal), squared = radius * radius - height * height;
  out[0] = out[1] = out[2] = 0;
  if (!(squared > 0)) return;
  const Vector edge = corner[1] - corner[0], e1 = edge / std::sqrt(dot(edge, edge)), e2 = cross(normal, e1);
  double at[3][2];
  for (int k = 0; k < 3; ++k) {
    const Vector from_middle = corner[k] - x;
    at[k][0] = dot(from_middle, e1);
    at[k][1] = dot(from_middle, e2);
  }
  Moments sum;
  for (int k = 0; k < 3; ++k) add_edge(std::sqrt(squared), at[k], at[(k + 1) % 3], sum);
  if (!(sum.area > 0)) return;
  const double twice = (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) - (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]);
  for (int k = 0; k < 3; ++k) {  // the function of corner k is cross(p - i, j - i) / twice, i and j the other corners
    const double *i = at[(k + 1) % 3], *j = at[(k + 2) % 3];
    out[k] =
        std::fmax(((sum.x - sum.area * i[0]) * (i[1] - j[1]) + (sum.y - sum.area * i[1]) * (j[0] - i[0])) / twice, 0);
  }
}

class Integration {
 public:
  Integration(const phn_body& body, ToolScratch& scratch) : _body(body), _scratch(scratch) {}

  /// @param corner, share  of the place: positions of up to three nodes, and their weights
  std::int32_t around(const std::int32_t* corner, const double* share) {
    const double radius = _body.info.tool_radius_m;
    Vector middle = {}, normal = {};
    for (int k = 0; k < 3; ++k)
      if (share[k] > 0) {
        middle += share[k] * point(corner[k]);
        normal += share[k] * vector_at(_body.normals + 3 * static_cast<std::size_t>(corner[k]));
      }
    normal /= std::fmax(std::sqrt(dot(normal, normal)), 1e-300);
    for (std::int32_t t = 0; t < _body.info.n_triangles; ++t) {
      bool has_all = true;
      for (int k = 0; k < 3; ++k) has_all = has_all && (!(share[k] > 0) || has(t, corner[k]));
      if (has_all) reach(t);
    }
    for (std::int32_t n = 0; n < _n_reached; ++n) {
      const std::int32_t t = _scratch.reached[n];
      Vector x[3];
      for (int k = 0; k < 3; ++k) x[k] = point(corners(t)[k]);
      const Vector area = cross(x[1] - x[0], x[2] - x[0]);
      const double size = std::sqrt(dot(area, area)), facing = dot(normal, area) / size;
      if (facing > 0) {
        double part[3];
        integrate(x, middle, radius, area / size, part);
        for (int k = 0; k < 3; ++k) add(corners(t)[k], facing * part[k]);
      }
      for (int k = 0; k < 3; ++k) {
        const std::int32_t other = _body.across[3 * static_cast<std::size_t>(t) + static_cast<std::size_t>(k)];
        if (other >= 0 && distance2_to_edge(middle, x[k], x[(k + 1) % 3]) < radius * radius) reach(other);
      }
    }
    for (std::int32_t n = 0; n < _n_reached; ++n) _scratch.taken[_scratch.reached[n]] = 0;
    return _n_touched;
  }

  void add(std::int32_t node, double weight) {
    if (_body.kinds[node] == schema::body_node_fixed || !(weight > 0)) return;
    if (_scratch.weight[node] == 0) _scratch.touched[_n_touched++] = node;
    _scratch.weight[node] += weight;
  }
  std::int32_t n_touched() const { return _n_touched; }

 private:
  const std::int32_t* corners(std::int32_t t) const { return _body.info.triangles + 3 * static_cast<std::size_t>(t); }
  bool has(std::int32_t t, std::int32_t node) const {
    return corners(t)[0] == node || corners(t)[1] == node || corners(t)[2] == node;
  }
  Vector point(std::int32_t node) const { return vector_at(_body.info.points + 3 * static_cast<std::size_t>(node)); }
  void reach(std::int32_t t) {
    if (_scratch.taken[t]) return;
    _scratch.taken[t] = 1;
    _scratch.reached[_n_reached++] = t;
  }

  const phn_body& _body;
  ToolScratch& _scratch;
  std::int32_t _n_reached = 0, _n_touched = 0;
};

/// Weights of the mean displacement under a tool: scratch.weight at the first n of scratch.touched. @param n  output
/// @return PHN_OK, PHN_WARNING_OUTSIDE or an error
int tool_weights(const phn_body& body, const phn_tool& tool, ToolScratch& scratch, std::int32_t& n) {
  std::int32_t corner[3];
  double share[3], sum = 0, fixed = 0;
  bool is_trained = true;
  n = 0;
  for (int k = 0; k < 3; ++k) {
    const double w = tool.weights[k];
    if (!(w >= -weight_slack && w <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
    sum += w;
    share[k] = w > no_weight ? w : 0;
    corner[k] = share[k] > 0 ? find_sorted(body.info.nodes, body.info.n_nodes, tool.nodes[k]) : 0;
    if (corner[k] < 0) return PHN_ERROR_ARGUMENT;
    if (share[k] > 0 && body.kinds[corner[k]] == schema::body_node_fixed) fixed += w;
    if (share[k] > 0 && body.kinds[corner[k]] == schema::body_node_moves) is_trained = false;
  }
  if (!(sum >= 1 - weight_slack && sum <= 1 + weight_slack)) return PHN_ERROR_ARGUMENT;
  if (!finite(tool.displacement)) return PHN_ERROR_NOT_FINITE;
  Integration integration(body, scratch);
  if (body.info.tool_radius_m > 0)
    n = integration.around(corner, share);
  else {
    for (int k = 0; k < 3; ++k) integration.add(corner[k], share[k]);
    n = integration.n_touched();
  }
  double total = 0;
  for (std::int32_t i = 0; i < n; ++i) total += scratch.weight[scratch.touched[i]];
  if (!(total > 0)) return PHN_ERROR_NOT_ACTIVE;
  for (std::int32_t i = 0; i < n; ++i) scratch.weight[scratch.touched[i]] /= total;
  return is_trained && fixed <= largest_fixed_weight<double> ? PHN_OK : PHN_WARNING_OUTSIDE;
}

/// Calls add(weight, rows of the modes) for the nodes under a tool. @return that of tool_weights
template <class Add>
int for_nodes_under(phn_body_state& state, const phn_tool& tool, const Add& add) {
  const phn_body& body = *state.body;
  std::int32_t n = 0;
  const int status = tool_weights(body, tool, state.scratch, n);
  for (std::int32_t t = 0; t < n; ++t) {
    const std::int32_t node = state.scratch.touched[t];
    add(state.scratch.weight[node], body.modes + 3 * static_cast<std::int64_t>(node) * body.stride);
    state.scratch.weight[node] = 0;
  }
  return status;
}

}  // namespace

int means_of_modes(phn_body_state& state, const phn_tool& tool, double* rows) {
  const std::int32_t n = 3 * state.body->stride;
  set_zero(rows, static_cast<std::size_t>(n));
  return for_nodes_under(state, tool, [&](double weight, const float* modes) {
    for (std::int32_t m = 0; m < n; ++m) rows[m] += weight * modes[m];
  });
}

void mean_displacement(phn_body_state& state, const phn_tool& tool, double mean[3]) {
  set_zero(mean, 3);
  for_nodes_under(state, tool, [&](double weight, const float* modes) {
    double moved[3];
    state.kernels->times(modes, 3, state.body->stride, state.at.q, moved);
    for (int k = 0; k < 3; ++k) mean[k] += weight * moved[k];
  });
}

}  // namespace PHN_RUNTIME
