#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <phynness/formats/error.hpp>
#include <sstream>

#include "geometry.hpp"
#include "surface.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;
constexpr int most_rounds = 60, rounds_per_ring = 4;
// Volumes over the cube of the longest edge. Coplanar triangles have volumes of rounding errors, with any sign.
constexpr double coplanar = 1e-9;

double orientation(const Vector& a, const Vector& b, const Vector& c, const Vector& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool segment_crosses(const Surface& s, std::int32_t p, std::int32_t q, std::int32_t triangle) {
  const auto t = s.triangles.row(triangle).array();
  if ((t == p).any() || (t == q).any()) return false;
  const auto [a, b, c] = corners_of(s.nodes, s.triangles, triangle);
  const Vector x = s.nodes.row(p), y = s.nodes.row(q);
  if (orientation(a, b, c, x) * orientation(a, b, c, y) > 0) return false;
  const double least =
      coplanar * std::pow(std::max({(y - x).norm(), (b - a).norm(), (c - b).norm(), (a - c).norm()}), 3);
  const double u = orientation(x, y, a, b), v = orientation(x, y, b, c), w = orientation(x, y, c, a);
  return std::min({u, v, w}) > least || std::max({u, v, w}) < -least;
}

bool cross(const Surface& s, std::int32_t first, std::int32_t second) {
  for (int k = 0; k < 3; ++k)
    if (segment_crosses(s, s.triangles(first, k), s.triangles(first, (k + 1) % 3), second) ||
        segment_crosses(s, s.triangles(second, k), s.triangles(second, (k + 1) % 3), first))
      return true;
  return false;
}

}  // namespace

std::vector<std::array<std::int32_t, 2>> crossing_triangles(const Surface& surface) {
  const Eigen::Index n = surface.triangles.rows();
  if (n == 0) return {};
  Points low(n, 3), high(n, 3);
  for (Eigen::Index t = 0; t < n; ++t) {
    const auto [a, b, c] = corners_of(surface.nodes, surface.triangles, t);
    low.row(t) = a.cwiseMin(b).cwiseMin(c);
    high.row(t) = a.cwiseMax(b).cwiseMax(c);
  }
  // A sweep along the longest axis has the fewest overlapping boxes.
  Eigen::Index axis = 0;
  (high.colwise().maxCoeff() - low.colwise().minCoeff()).maxCoeff(&axis);
  std::vector<std::int32_t> order(static_cast<std::size_t>(n)), open;
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](std::int32_t p, std::int32_t q) { return std::pair(low(p, axis), p) < std::pair(low(q, axis), q); });
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const std::int32_t t : order) {
    std::erase_if(open, [&](std::int32_t other) { return high(other, axis) < low(t, axis); });
    for (const std::int32_t other : open)
      if ((low.row(t).array() <= high.row(other).array()).all() &&
          (low.row(other).array() <= high.row(t).array()).all() && cross(surface, t, other))
        pairs.push_back({std::min(t, other), std::max(t, other)});
    open.push_back(t);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void untangle(Surface& surface, std::vector<std::string>& notes) {
  auto pairs = crossing_triangles(surface);
  if (pairs.empty()) return;
  const std::size_t at_first = pairs.size();
  const Points before = surface.nodes;
  std::vector<std::vector<std::int32_t>> neighbours(static_cast<std::size_t>(surface.nodes.rows()));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) neighbours[surface.triangles(t, k)].push_back(surface.triangles(t, (k + 1) % 3));
  std::vector<char> moving(neighbours.size(), 0);
  for (int round = 0; round < most_rounds && !pairs.empty(); ++round) {
    for (const auto& pair : pairs)
      for (const std::int32_t t : pair)
        for (int k = 0; k < 3; ++k) moving[surface.triangles(t, k)] = 1;
    if (round % rounds_per_ring == 0) {
      const std::vector<char> inner = moving;
      for (std::size_t i = 0; i < inner.size(); ++i)
        if (inner[i])
          for (const std::int32_t other : neighbours[i]) moving[other] = 1;
    }
    const Points old = surface.nodes;
    for (std::size_t i = 0; i < moving.size(); ++i) {
      if (!moving[i]) continue;
      Vector center = Vector::Zero();
      for (const std::int32_t other : neighbours[i])
        center += old.row(other) / static_cast<double>(neighbours[i].size());
      surface.nodes.row(static_cast<Eigen::Index>(i)) = (old.row(static_cast<Eigen::Index>(i)) + center) / 2;
    }
    pairs = crossing_triangles(surface);
  }
  std::ostringstream text;
  if (!pairs.empty()) {
    text << counted(at_first, "pair", "pairs") << " of triangles, first " << pairs[0][0] << " and " << pairs[0][1];
    throw input_error("the surface intersects itself, and smoothing does not remove the intersections", text.str(),
                      "repair the surface in the program that made it");
  }
  text << "smoothed the surface where it intersected itself (" << counted(at_first, "pair", "pairs")
       << " of triangles): moved " << std::count(moving.begin(), moving.end(), 1) << " nodes by at most "
       << (surface.nodes - before).rowwise().norm().maxCoeff() << " m";
  notes.push_back(text.str());
}

}  // namespace phynness::meshes
