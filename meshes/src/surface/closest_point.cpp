#include "closest_point.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "geometry.hpp"

namespace phynness::meshes {
namespace {

using Vector = Eigen::RowVector3d;

Vector on_segment(const Vector& x, const Vector& a, const Vector& b) {
  const Vector ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? Vector(a + std::clamp((x - a).dot(ab) / length2, 0.0, 1.0) * ab) : a;
}

Vector on_triangle(const Vector& x, const Vector& a, const Vector& b, const Vector& c) {
  // The barycentric coordinates of the foot point follow from the 2x2 normal equations; if it is outside of the
  // triangle, the closest point lies on an edge.
  const Vector u = b - a, v = c - a, d = x - a;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), du = d.dot(u), dv = d.dot(v);
  const double det = uu * vv - uv * uv;
  if (det > 1e-14 * uu * vv) {
    const double s = (vv * du - uv * dv) / det, t = (uu * dv - uv * du) / det;
    if (s >= 0 && t >= 0 && s + t <= 1) return a + s * u + t * v;
  }
  Vector best = on_segment(x, a, b);
  for (const Vector& candidate : {on_segment(x, b, c), on_segment(x, c, a)})
    if ((candidate - x).squaredNorm() < (best - x).squaredNorm()) best = candidate;
  return best;
}

double distance2(const Vector& x, const Vector& low, const Vector& high) {
  return (low - x).cwiseMax(x - high).cwiseMax(0).squaredNorm();
}

}  // namespace

ClosestPoint::ClosestPoint(const Surface& surface)
    : _surface(surface), _order(static_cast<std::size_t>(surface.triangles.rows())) {
  std::iota(_order.begin(), _order.end(), 0);
  Points centroids(surface.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < centroids.rows(); ++t) {
    const auto [a, b, c] = corners_of(surface.nodes, surface.triangles, t);
    centroids.row(t) = (a + b + c) / 3;
  }
  build(0, static_cast<std::int32_t>(_order.size()), centroids);
}

std::int32_t ClosestPoint::build(std::int32_t first, std::int32_t last, const Points& centroids) {
  constexpr std::int32_t leaf_size = 4;
  Box box;
  box.first = first, box.last = last;
  box.low.setConstant(std::numeric_limits<double>::infinity());
  box.high = -box.low;
  for (std::int32_t i = first; i < last; ++i)
    for (const Vector& x : corners_of(_surface.nodes, _surface.triangles, _order[i])) {
      box.low = box.low.cwiseMin(x);
      box.high = box.high.cwiseMax(x);
    }
  const auto index = static_cast<std::int32_t>(_boxes.size());
  _boxes.push_back(box);
  if (last - first > leaf_size) {
    Eigen::Index axis = 0;
    (box.high - box.low).maxCoeff(&axis);
    const std::int32_t middle = (first + last) / 2;
    std::nth_element(_order.begin() + first, _order.begin() + middle, _order.begin() + last,
                     [&](std::int32_t p, std::int32_t q) {
                       return std::pair(centroids(p, axis), p) < std::pair(centroids(q, axis), q);
                     });
    const std::int32_t left = build(first, middle, centroids), right = build(middle, last, centroids);
    _boxes[index].left = left;
    _boxes[index].right = right;
  }
  return index;
}

Eigen::RowVector3d ClosestPoint::operator()(const Eigen::RowVector3d& x) const {
  double best2 = std::numeric_limits<double>::infinity();
  Vector best = x;
  std::vector<std::int32_t> stack{0};
  while (!stack.empty()) {
    const Box& box = _boxes[stack.back()];
    stack.pop_back();
    if (distance2(x, box.low, box.high) >= best2) continue;
    if (box.left < 0) {
      for (std::int32_t i = box.first; i < box.last; ++i) {
        const auto [a, b, c] = corners_of(_surface.nodes, _surface.triangles, _order[i]);
        const Vector candidate = on_triangle(x, a, b, c);
        if (const double d2 = (candidate - x).squaredNorm(); d2 < best2) best2 = d2, best = candidate;
      }
      continue;
    }
    const Box &left = _boxes[box.left], &right = _boxes[box.right];
    const bool left_first = distance2(x, left.low, left.high) <= distance2(x, right.low, right.high);
    stack.push_back(left_first ? box.right : box.left);
    stack.push_back(left_first ? box.left : box.right);
  }
  return best;
}

}  // namespace phynness::meshes
