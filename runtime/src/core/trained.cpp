// The training data of a node: distances from it, and bounds of errors.
#include <cmath>

#include "core/bound.hpp"
#include "core/evaluate.hpp"

namespace PHN_RUNTIME {
namespace {

/// Squares of components up to this size do not overflow.
constexpr double largest_component = 1e150;

/// Sampled directions pass through the centers of side x side squares on each face of a cube. They are 6 to 14 degrees
/// apart; the gaps between the 26 exploratory directions measure 28 degrees.
constexpr int side = 8;
/// Fractions of the trained depth at which they are sampled.
constexpr double parts[] = {1, 0.75, 0.5, 0.25};

/// Largest number of increments of a direction; further ones are ignored.
constexpr std::int32_t most_increments = 64;

void cube_direction(int i, double* e) {
  const int face = i / (side * side), row = i / side % side, column = i % side;
  const double across[3] = {face % 2 == 0 ? 1.0 : -1.0, (2 * row + 1.0) / side - 1, (2 * column + 1.0) / side - 1};
  const double size = std::sqrt(dot(across, across));
  for (int k = 0; k < 3; ++k) e[(face / 2 + k) % 3] = across[k] / size;
}

/// A row of the displacements, over max_displacement.
void row_of(const phn_model& model, std::int32_t row, double* x) {
  const double unit = schema::traits(model.kind).has_modes ? 1 : model.max_displacement_m;
  for (int k = 0; k < 3; ++k) x[k] = model.displacements[3 * static_cast<std::size_t>(row) + k] / unit;
}

/// Even and odd directions are compared independently, which a processor does at the same time.
std::int32_t nearest_direction(const phn_model& model, const double* d) {
  const double *e = model.directions, *end = e + 3 * static_cast<std::size_t>(model.n_directions), *even = e, *odd = e;
  double best_even = dot(d, e), best_odd = best_even;
  for (e += 3; e + 3 < end; e += 6) {
    const double a = dot(d, e), b = dot(d, e + 3);
    if (a > best_odd) {
      best_odd = a;
      odd = e;
    }
    if (b > best_even) {
      best_even = b;
      even = e + 3;
    }
  }
  if (e < end && dot(d, e) > best_odd) {
    best_odd = dot(d, e);
    odd = e;
  }
  return static_cast<std::int32_t>(((best_odd > best_even ? odd : even) - model.directions) / 3);
}

}  // namespace

double fill_distance(const phn_model& model, const double* depths) {
  const std::int32_t n_increments = model.n_displacements / model.n_directions;
  const std::int32_t n = n_increments < most_increments ? n_increments : most_increments;
  double length_of[most_increments];  // of direction 0; all directions have the same
  for (std::int32_t j = 0; j < n; ++j) {
    double x[3];
    row_of(model, j, x);
    length_of[j] = std::sqrt(dot(x, x));
  }
  double largest = 0;
  for (int i = 0; i < 6 * side * side; ++i) {
    double e[3], cosine[most_increments];
    cube_direction(i, e);
    const double unit = 1, R = model.max_displacement_m;
    const double depth = depth_along(model.directions, depths, model.n_directions, e, unit, R) / R;
    for (std::int32_t j = 0; j < n; ++j) cosine[j] = -2;
    for (std::int32_t k = 0; k < model.n_directions; ++k) {
      const double along = dot(e, model.directions + 3 * static_cast<std::size_t>(k));
      const double reach = depth_slack<double> * depths[k] / model.max_displacement_m;
      for (std::int32_t j = 0; j < n && length_of[j] <= reach; ++j) cosine[j] = std::fmax(cosine[j], along);
    }
    for (const double part : parts) {
      const double r = part * depth;
      double square = r * r;  // from rest
      for (std::int32_t j = 0; j < n; ++j) {
        if (cosine[j] >= -1) square = std::fmin(square, r * r + length_of[j] * (length_of[j] - 2 * r * cosine[j]));
      }
      largest = std::fmax(largest, square);
    }
  }
  return largest > 0 && std::isfinite(largest) ? std::sqrt(largest) : 1;
}

double error_bound(const phn_model& model, const ActiveNode& node, const double* d) {
  const std::int32_t n_increments = model.n_displacements / model.n_directions;
  const std::int32_t first = nearest_direction(model, d) * n_increments;
  // Rows are in units of max_displacement in a family with modes, in m in the others.
  const double unit = schema::traits(model.kind).has_modes ? model.max_displacement_m : 1;
  return bound_along(model.displacements + 3 * static_cast<std::size_t>(first), n_increments, node.bound + first,
                     node.bound_scale, dot(d, d) / (unit * unit), [&] { return node.bound_at_rest; });
}

double trained_distance(const phn_model& model, const ActiveNode& node, const double* d) {
  const std::int32_t n_increments = model.n_displacements / model.n_directions;
  double x[3];
  cut(d, model.max_displacement_m, largest_component, x);
  double square = dot(x, x);  // from rest
  for (std::int32_t k = 0; k < model.n_directions; ++k) {
    const double reach = depth_slack<double> * node.trained_depth[k] / model.max_displacement_m;
    for (std::int32_t j = 0; j < n_increments; ++j) {
      double at[3];
      row_of(model, k * n_increments + j, at);
      const double y[3] = {x[0] - at[0], x[1] - at[1], x[2] - at[2]};
      const double now = dot(y, y);
      if (now < square && dot(at, at) <= reach * reach) square = now;
    }
  }
  return std::sqrt(square);
}

}  // namespace PHN_RUNTIME
